"""The command `fatplan`: options in, work by the layers below, messages and exit codes out."""

import signal
import sys
from types import FrameType
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from fatigue_planner import __version__
from fatigue_planner.cli.benchmark import benchmark
from fatigue_planner.cli.figures import figures
from fatigue_planner.cli.human import app as human
from fatigue_planner.cli.simulate import simulate
from fatigue_planner.errors import ExitCode, FatplanError

EXIT_CODES = (
    "Exit codes: 0 done; 1 internal error; 2 bad input or usage; 3 finished, but some parts failed; "
    "4 a stored file is damaged; 130 or 143 interrupted, with everything finished so far kept."
)

app = typer.Typer(
    name="fatplan",
    help="Plan a cobot's choices so that a worker's fatigue stays low in the long run.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command(epilog=EXIT_CODES)(simulate)
app.command(epilog=EXIT_CODES)(benchmark)
app.command(epilog=EXIT_CODES)(figures)
app.add_typer(human, name="human", epilog=EXIT_CODES)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"fatplan {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass


class Stopped(BaseException):
    """SIGINT or SIGTERM, raised where the program is, so that it leaves in good order."""

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.exit_code = ExitCode.INTERRUPTED if signal_number == signal.SIGINT else ExitCode.TERMINATED


def _stop(signal_number: int, _frame: FrameType | None) -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    raise Stopped(signal_number)


def run() -> None:
    """Run the command line; every mistake of the user ends in one message and its exit code.

    The first signal stops in good order, a second one at once.
    """
    errors = Console(stderr=True, highlight=False, soft_wrap=True)
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _stop)
    try:
        app()
    except FatplanError as error:
        errors.print(Text.assemble(("Error:", "red"), f" {error}"))
        sys.exit(error.exit_code)
    except Stopped as stopped:
        errors.print("Stopped. What is finished is kept; the same command goes on from there.")
        sys.exit(stopped.exit_code)

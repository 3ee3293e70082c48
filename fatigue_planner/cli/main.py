"""The command `fatplan` and its subcommands: options in, work by the layers below, messages out."""

from typing import Annotated

import typer

from fatigue_planner import __version__
from fatigue_planner.cli.benchmark import benchmark
from fatigue_planner.cli.cache import app as cache
from fatigue_planner.cli.claims import claims
from fatigue_planner.cli.compare import compare
from fatigue_planner.cli.doctor import doctor
from fatigue_planner.cli.figures import figures
from fatigue_planner.cli.human import app as human
from fatigue_planner.cli.options import EXIT_CODES
from fatigue_planner.cli.report import report
from fatigue_planner.cli.sensitivity import sensitivity
from fatigue_planner.cli.simulate import simulate
from fatigue_planner.cli.validate import schema, validate
from fatigue_planner.cli.view import view

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
app.command(epilog=EXIT_CODES)(claims)
app.command(epilog=EXIT_CODES)(figures)
app.command(epilog=EXIT_CODES)(report)
app.command(epilog=EXIT_CODES)(compare)
app.command(epilog=EXIT_CODES)(sensitivity)
app.command(epilog=EXIT_CODES)(view)
app.command(epilog=EXIT_CODES)(validate)
app.command(epilog=EXIT_CODES)(schema)
app.command(epilog=EXIT_CODES)(doctor)
app.add_typer(human, name="human", epilog=EXIT_CODES)
app.add_typer(cache, name="cache", epilog=EXIT_CODES)


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

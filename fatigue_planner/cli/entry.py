"""Where the process starts: streams and signals first, so that even its loading can be stopped in good order."""

import os
import signal
import sys

from fatigue_planner.cli.failure import tell_stopped
from fatigue_planner.cli.signals import Signals, Stopped
from fatigue_planner.core.errors import ExitCode


def run() -> None:
    """Run the command line; every mistake of the user ends in one message and its exit code.

    The first signal stops in good order, a second one at once.
    """
    arguments = sys.argv[1:]
    signals = Signals(lambda stopped: tell_stopped(arguments, stopped))
    signals.install()
    _prepare_streams()
    code: int = ExitCode.INTERNAL_ERROR
    try:
        code = _outcome(arguments, signals)
        signals.work_is_done()
    except Stopped as stopped:
        code = tell_stopped(arguments, stopped)
    _give_up_unwritten()
    sys.exit(code)


def _outcome(arguments: list[str], signals: Signals) -> int:
    from fatigue_planner.cli.run_command import ReaderGoneError, disk_fault, outcome  # noqa: PLC0415 - after the signals

    try:
        code = outcome(arguments, signals.work_begins)
        if sys.stdout is not None:
            sys.stdout.flush()
    except (ReaderGoneError, BrokenPipeError):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # end as every program does whose reader has gone
        os.kill(os.getpid(), signal.SIGPIPE)
        raise
    except OSError as error:  # what should have been printed cannot be written
        return disk_fault(arguments, error)
    return code


def _give_up_unwritten() -> None:
    """Python would complain at its end about what its streams could not write."""
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _prepare_streams() -> None:
    """Keep files from getting the number of a standard stream that is closed; no colours where none are wanted."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number, this one
    terminal = sys.stdout is not None and sys.stdout.isatty()
    if os.environ.get("NO_COLOR") or not (terminal or os.environ.get("FORCE_COLOR")):
        os.environ["_TYPER_FORCE_DISABLE_TERMINAL"] = "1"  # of the help; NO_COLOR alone leaves it bold and dim

"""Where the process starts: signals first, so that even loading the program can be stopped in good order."""

import signal
import sys
from types import FrameType

from fatigue_planner.errors import ExitCode, FatplanError


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
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _stop)
    try:
        from fatigue_planner.cli.main import app  # noqa: PLC0415 - takes two seconds

        app()
    except FatplanError as error:
        print(f"Error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except Stopped as stopped:
        print("Stopped. What is finished is kept; the same command goes on from there.", file=sys.stderr)
        sys.exit(stopped.exit_code)

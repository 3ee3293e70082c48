"""Ctrl-C and termination: the first stops in good order, a second at once."""

import os
import signal
import sys
from collections.abc import Callable
from types import FrameType

from fatigue_planner.core.errors import ExitCode

STOPPING = (signal.SIGINT, signal.SIGTERM)
AGAIN_AFTER_S = 0.05


class Stopped(BaseException):
    """SIGINT or SIGTERM, raised where the program is, so that it leaves in good order."""

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.exit_code = ExitCode.INTERRUPTED if signal_number == signal.SIGINT else ExitCode.TERMINATED


class Signals:
    """What the signals do, from the start of the process to its end.

    While the program is being loaded nothing is worth finishing, and an exception out of the middle of an import can
    get lost in it: the process says `farewell` and ends. While a command works, `Stopped` is raised.
    """

    def __init__(self, farewell: Callable[[Stopped], object]) -> None:
        self._farewell = farewell
        self._working = False

    def install(self) -> None:
        """Begin to listen; a signal that the parent had ignored stays ignored."""
        for number in STOPPING:
            if signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._stop)
        sys.unraisablehook = self._not_lost

    def work_begins(self) -> None:
        """Everything is loaded; from now on something can be lost."""
        self._working = True

    def work_is_done(self) -> None:
        """All is written: what is left is to leave, which takes no time and needs no message."""
        for number in STOPPING:
            if signal.getsignal(number) == self._stop:
                signal.signal(number, signal.SIG_IGN)

    def _stop(self, number: int, _frame: FrameType | None) -> None:
        for one in STOPPING:
            signal.signal(one, signal.SIG_DFL)
        stopped = Stopped(number)
        if self._working:
            raise stopped
        self._farewell(stopped)
        os._exit(stopped.exit_code)

    def _not_lost(self, unraisable: "sys.UnraisableHookArgs") -> None:
        """Python cannot raise out of a destructor or a weak reference's callback: raise a moment later once more."""
        error = unraisable.exc_value
        if not isinstance(error, Stopped):
            sys.__unraisablehook__(unraisable)
            return

        def raise_again(_number: int, _frame: FrameType | None) -> None:
            raise error

        signal.signal(signal.SIGALRM, raise_again)
        signal.setitimer(signal.ITIMER_REAL, AGAIN_AFTER_S)

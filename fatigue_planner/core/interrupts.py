"""SIGINT (Ctrl-C) and SIGTERM: the first one stops the program in good order, a second one ends it at once.

From `stop_on_signals` to the end of the process a handler is always there: one is only ever replaced by another.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any, Self

from fatigue_planner.core.errors import ExitCode

STOPPING = (signal.SIGINT, signal.SIGTERM)

_NOTED = b"Stopping after the work in progress (once more to stop at once) ...\n"
_STDERR = 2
_AGAIN_AFTER_S = 0.05


class Stopped(BaseException):
    """SIGINT or SIGTERM, raised where the program is, so that it leaves in good order."""

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.exit_code = ExitCode.INTERRUPTED if signal_number == signal.SIGINT else ExitCode.TERMINATED


def stop_on_signals(farewell: Callable[[Stopped], object]) -> None:
    """From now on the first signal raises `Stopped`; one that the parent process ignores stays ignored.

    In the middle of an import, where an exception can get lost and nothing is worth finishing, the process says
    `farewell` and ends.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        _end_at_the_next()
        stopped = Stopped(number)
        if not _is_importing(frame):
            raise stopped
        farewell(stopped)
        os._exit(stopped.exit_code)

    for number in STOPPING:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, stop)
    sys.unraisablehook = _raise_again


def ignore_signals() -> None:
    """All is written: what is left is to leave, which takes no time and needs no message."""
    for number in STOPPING:
        signal.signal(number, signal.SIG_IGN)


def _end_at_the_next() -> None:
    for number in STOPPING:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _raise_again(unraisable: "sys.UnraisableHookArgs") -> None:
    """Python cannot raise out of a destructor or a weak reference's callback: raise a moment later once more."""
    error = unraisable.exc_value
    if not isinstance(error, Stopped):
        sys.__unraisablehook__(unraisable)
        return

    def raise_again(_number: int, _frame: FrameType | None) -> None:
        raise error

    signal.signal(signal.SIGALRM, raise_again)
    signal.setitimer(signal.ITIMER_REAL, _AGAIN_AFTER_S)


class Interrupts:
    """Inside it the first signal is only noted, wherever the program is; a second one ends the process.

    At its end what was noted goes to whoever handles that signal otherwise. Signals that nobody handles stay as they
    are, and so do all outside the main thread, where Python receives none.
    """

    def __init__(self) -> None:
        self.noted: int | None = None
        self._handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in STOPPING:
                handler = signal.getsignal(number)
                if callable(handler):
                    self._handlers[number] = handler
                    signal.signal(number, self._note)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        if self.noted is not None and (error is None or isinstance(error, GeneratorExit)):
            self._handlers[self.noted](self.noted, None)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self.noted = number
        for handled in self._handlers:
            signal.signal(handled, signal.SIG_DFL)
        with suppress(OSError):  # not print: the signal may have come in the middle of one
            os.write(_STDERR, _NOTED)

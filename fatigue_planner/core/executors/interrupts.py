"""Ctrl-C and termination while work is in progress: noted, and heard when that is done and stored."""

import os
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any, Self

_TELLING = b"Stopping after the work in progress (once more to stop at once) ...\n"
_STDERR = 2


class Interrupts:
    """Inside it the first SIGINT or SIGTERM is only noted, wherever the program is; a second one ends the process.

    At its end what was noted goes to whoever handles that signal otherwise. Signals that nobody handles stay as they
    are, and so do all outside the main thread, where Python hears none.
    """

    def __init__(self) -> None:
        self.noted: int | None = None
        self._handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
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
        for one in self._handlers:
            signal.signal(one, signal.SIG_DFL)
        with suppress(OSError):  # not print: the signal may have come in the middle of one
            os.write(_STDERR, _TELLING)

"""A signal is heard wherever it comes: at every line of what begins work, waits for it and handles signals."""

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

import pytest
from pieces import Interrupt, interruptible
from threads import Threads

from fatigue_planner.core import interrupts
from fatigue_planner.core.executors import executor

BEGUN: list[int] = []


def begin(number: int) -> int:
    BEGUN.append(number)
    return number


@contextmanager
def at_line(number: int, act: Callable[[], None]) -> Iterator[list[int]]:
    """Act before the given line, counted as they are executed, of the two files; yields the count of lines."""
    lines = [0]

    def trace(frame: FrameType, event: str, _: object) -> object:
        if frame.f_code.co_filename not in (interrupts.__file__, executor.__file__):
            return None
        if event == "line":
            lines[0] += 1
            if lines[0] == number:
                act()
        return trace

    before = sys.gettrace()
    sys.settrace(trace)  # type: ignore[arg-type]
    try:
        yield lines
    finally:
        sys.settrace(before)


def test_at_every_line_an_interrupt_is_raised_once_and_what_is_begun_is_delivered(
    capfd: pytest.CaptureFixture[str],
) -> None:
    number, reached = 0, True
    while reached:
        number += 1
        BEGUN.clear()
        found: list[int] = []
        raised = 0
        with interruptible():
            handler = signal.getsignal(signal.SIGINT)
            try:
                with at_line(number, lambda: signal.raise_signal(signal.SIGINT)) as lines:
                    found.extend(index for index, _ in Threads(2).run(begin, range(6)))
            except Interrupt:
                raised = 1
            assert signal.getsignal(signal.SIGINT) == handler, number
        reached = lines[0] >= number
        assert raised == reached, number
        assert sorted(found) == sorted(BEGUN), number
    assert number > 40
    assert "Traceback" not in capfd.readouterr().err

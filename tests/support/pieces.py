"""Pieces of work for any executor; workers load nothing but this for them."""

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.study.benchmark.job import Job


def square(number: int) -> int:
    return number * number


def process_id(_number: int) -> int:
    return os.getpid()


def slow_square(number: int) -> int:
    time.sleep(0.2)
    return number * number


def die(item: tuple[Path, int, int]) -> int:
    """Kill the own process the first so many times; counts the attempts in a folder."""
    folder, number, deaths = item
    attempt = len(list(folder.glob(f"{number}-*")))
    (folder / f"{number}-{attempt}").touch()
    if attempt < deaths:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def fail(number: int) -> int:
    if number == 3:
        raise FailedMotionError("the third")
    return number


def complain(text: str) -> None:
    print(text, file=sys.stderr)


class Interrupt(BaseException):
    pass


@contextmanager
def interruptible() -> Iterator[None]:
    """SIGINT raises Interrupt, as whoever runs the program may have it."""

    def interrupted(_number: int, _frame: object) -> None:
        raise Interrupt

    before = signal.signal(signal.SIGINT, interrupted)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def interrupt_after(delay_s: float) -> None:
    """Send SIGINT to this process, now or in a moment."""
    if delay_s:
        threading.Timer(delay_s, os.kill, [os.getpid(), signal.SIGINT]).start()
    else:
        os.kill(os.getpid(), signal.SIGINT)


@dataclass(frozen=True)
class Squared:
    """What a trial of Deadly comes to."""

    square: int


@dataclass(frozen=True)
class Deadly(Job[Squared]):
    """Twenty trials one of which kills the process that does it; the attempts are counted in a folder."""

    folder: Path
    trial: int

    result_type = Squared

    @property
    def name(self) -> str:
        return "deadly"

    @property
    def effort(self) -> int:
        return 1

    def key(self) -> str:
        return "deadly"

    def trial_numbers(self) -> Sequence[int]:
        return range(20)

    def run(self, trials: Sequence[int]) -> dict[int, Squared]:
        if self.trial in trials:
            die((self.folder, self.trial, 99))
        return {trial: Squared(square(trial)) for trial in trials}

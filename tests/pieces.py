"""Pieces of work for any executor; workers load nothing but this for them."""

import os
import signal
import time
from pathlib import Path

from fatigue_planner.errors import FailedMotionError


def square(number: int) -> int:
    return number * number


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


class Interrupt(BaseException):
    pass


def interrupted(_number: int, _frame: object) -> None:
    raise Interrupt

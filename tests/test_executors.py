"""Work survives the workers that do it."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from fatigue_planner.executors.executor import MOST_DEATHS, Lost
from fatigue_planner.executors.processes import LocalProcesses


def square(number: int) -> int:
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
        raise ValueError("three")
    return number


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_every_item_is_done_once(jobs: int) -> None:
    found = list(LocalProcesses(jobs).run(square, range(20)))
    assert sorted(found) == [(place, place * place) for place in range(20)]
    assert list(LocalProcesses(jobs).run(square, [])) == []


def test_work_whose_process_dies_is_done_again_and_given_up_in_the_end(tmp_path: Path) -> None:
    """Two pieces lose their process once or twice and are done; one always does, and takes nothing with it."""
    deaths = [0, 1, 0, 2, 0, 99, 0, 0]
    items = [(tmp_path, number, count) for number, count in enumerate(deaths)]
    found = dict(LocalProcesses(2).run(die, items))
    assert isinstance(found.pop(5), Lost)
    assert found == {number: number for number in range(8) if number != 5}
    assert len(list(tmp_path.glob("5-*"))) <= MOST_DEATHS + 1  # once in company


def test_an_error_of_the_work_is_raised() -> None:
    with pytest.raises(ValueError, match="three"):
        list(LocalProcesses(2).run(fail, range(10)))


class Interrupt(BaseException):
    pass


def interrupted(_number: int, _frame: object) -> None:
    raise Interrupt


def slow(number: int) -> int:
    time.sleep(0.3)
    return number


def test_after_an_interrupt_what_is_in_progress_is_still_delivered(capsys: pytest.CaptureFixture[str]) -> None:
    def until_interrupted() -> Iterator[int]:
        for place, _ in LocalProcesses(2).run(slow, range(50)):
            yield place
            if place == 1:
                signal.setitimer(signal.ITIMER_REAL, 0.05)

    found = []
    before = signal.signal(signal.SIGALRM, interrupted)
    try:
        with pytest.raises(Interrupt):
            found.extend(until_interrupted())
    finally:
        signal.signal(signal.SIGALRM, before)
    assert 2 <= len(found) <= 8
    assert "Stopping after the work in progress" in capsys.readouterr().err

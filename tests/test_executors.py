"""Work survives the workers that do it."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from pieces import Interrupt, die, fail, interrupted, slow_square, square

from fatigue_planner.errors import FailedMotionError
from fatigue_planner.executors.executor import MOST_DEATHS, Lost
from fatigue_planner.executors.processes import LocalProcesses


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
    with pytest.raises(FailedMotionError, match=r"^the third$"):
        list(LocalProcesses(2).run(fail, range(10)))


def test_after_an_interrupt_what_is_in_progress_is_still_delivered(capsys: pytest.CaptureFixture[str]) -> None:
    def until_interrupted() -> Iterator[int]:
        for place, _ in LocalProcesses(2).run(slow_square, range(50)):
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

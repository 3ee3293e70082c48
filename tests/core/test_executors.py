"""Work survives the workers that do it."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from pieces import Interrupt, die, fail, interrupt_after, interruptible, slow_square, square

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.core.executors.executor import Lost
from fatigue_planner.core.executors.processes import LocalProcesses


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
    assert len(list(tmp_path.glob("5-*"))) == 4  # once in company, three times alone


def test_an_error_of_the_work_is_raised() -> None:
    with pytest.raises(FailedMotionError, match=r"^the third$"):
        list(LocalProcesses(2).run(fail, range(10)))


@pytest.mark.parametrize("delay_s", [0.0, 0.15], ids=["while a result is stored", "while waiting"])
def test_after_an_interrupt_what_is_in_progress_is_still_delivered(
    capfd: pytest.CaptureFixture[str], delay_s: float
) -> None:
    def until_interrupted() -> Iterator[int]:
        for place, _ in LocalProcesses(2).run(slow_square, range(50)):
            yield place
            if place == 1:
                interrupt_after(delay_s)

    found = []
    with interruptible(), pytest.raises(Interrupt):
        found.extend(until_interrupted())
    assert 4 <= len(found) <= 8
    assert capfd.readouterr().err == "Stopping after the work in progress (once more to stop at once) ...\n"


def test_an_interrupt_at_the_very_end_is_heard() -> None:
    with interruptible(), pytest.raises(Interrupt):
        for place, _ in LocalProcesses(1).run(square, range(3)):
            if place == 2:
                interrupt_after(0)

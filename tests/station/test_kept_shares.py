"""What is kept of a population: found again as long as nothing that decides it has changed, whatever it is called."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from test_station_file import station

from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.station import kept_shares
from fatigue_planner.station.assessment import ReachShare
from fatigue_planner.station.kept_shares import FOLDER, key, reach_shares
from fatigue_planner.station.population_reach import Question, questions
from fatigue_planner.station.schema import Station


class Answers(LocalProcesses):
    """Says a share of its own at once to whatever is asked, and counts it."""

    def __init__(self) -> None:
        super().__init__(1)
        self.asked: list[tuple[str, str]] = []

    def run(self, function: Callable[[Any], Any], arguments: Sequence[Any]) -> Iterator[tuple[int, Any]]:  # type: ignore[override]
        for index, question in reversed(list(enumerate(arguments))):
            self.asked.append((question.place, question.sex))
            share = 0.1 * len(self.asked)
            yield index, ReachShare(question.operation, question.place, question.sex, 1.5, None, share, 0, 1, None, "")


def first(said: Station) -> Question:
    return next(questions(said))


def test_what_is_kept_is_found_again(tmp_path: Path) -> None:
    executor, heard = Answers(), [0]

    def count() -> None:
        heard[0] += 1

    made = reach_shares(station(), tmp_path, executor, count)
    assert len(executor.asked) == heard[0] == len(made) == 6
    again = reach_shares(station(), tmp_path, executor, count)
    assert again == made and len(executor.asked) == 6 and heard[0] == 12
    # one place is another: what is known of the others stays, and is called as they are called now
    places = {name: at.plain() for name, at in station().places.items()}
    places["door"]["z"], places["roof"] = 1.1, places.pop("overhead")
    fit = {"fit": {"places": ["roof", "door", "plug"], "seconds": 9}}
    other = reach_shares(station(places=places, operations=fit), tmp_path, executor)
    assert executor.asked[6:] == [("door", "male"), ("door", "female")]
    assert other[:2] == [replace(each, place="roof") for each in made[:2]] and other[4:] == made[4:]


def test_what_is_damaged_is_asked_again(tmp_path: Path) -> None:
    executor = Answers()
    made = reach_shares(station(), tmp_path, executor)
    file, moved, *_ = sorted((tmp_path / FOLDER).iterdir())
    file.write_text(file.read_text().replace("1.5", "1.6"))
    moved.write_text(json.dumps({"key": {}, "share": {}}))
    assert len(reach_shares(station(), tmp_path, executor)) == len(made) and len(executor.asked) == 8


@pytest.mark.parametrize(
    "more",
    [
        {"shoes_m": 0.03},
        {"ways": ["arm"]},
        {"feet": "fixed"},
        {"tools": {"screwdriver": "1.3 kg", "gun": "3 kg"}},
        {"cycle": {"duration_s": 42, "reach_s": 4}},
        {"population": {sex: {"stature_m": {"mean": 1.6, "sd": 0.06}} for sex in ("female", "male")}},
        {"operations": {"fit": {"places": ["overhead"], "seconds": 25, "hand": "left"}}},
    ],
)
def test_what_decides_is_in_the_key(more: dict[str, Any]) -> None:
    assert key(first(station())) != key(first(station(**more)))


def test_of_whom_is_asked_is_in_the_key() -> None:
    """Also where the worker of the median stature stays the same."""

    def with_deviation(sd: float) -> dict[str, Any]:
        people = {sex: {"stature_m": {"mean": 1.6, "sd": sd}} for sex in ("female", "male")}
        return key(first(station(population=people)))

    assert with_deviation(0.06) != with_deviation(0.07)


def test_sources_and_versions_are_in_the_key(monkeypatch: pytest.MonkeyPatch) -> None:
    before = key(first(station()))
    for name in ("digest_of_package", "versions_of"):
        with monkeypatch.context() as patched:
            patched.setattr(kept_shares, name, lambda *_: "another")
            assert key(first(station())) != before
    assert key(first(station(operations={"other": {"places": ["overhead"], "seconds": 3}}))) == before

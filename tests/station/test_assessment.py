"""A whole assessment: the car line that ships, shorter, and three operations that must all be done."""

import csv
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from commands import fatplan
from conftest import ROOT
from test_station_file import station

from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.ergonomics.result import Level
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.planners.schedules.cost import schedule_cost
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.station.assess import whole_cycles
from fatigue_planner.station.assessment import Sensing
from fatigue_planner.station.bound_experiments import bound_experiments
from fatigue_planner.station.changes import changed_stations, changes_of
from fatigue_planner.station.examine import Examined, examine
from fatigue_planner.station.loader import load_station
from fatigue_planner.station.rotation import DISCOUNT, best_rotation
from fatigue_planner.station.sensing import scenario_of, sensing_of, ways_of
from fatigue_planner.station.statements import headline_of, of_changes
from fatigue_planner.study.schedule import start_of

pytestmark = pytest.mark.slow

LINE = yaml.safe_load((ROOT / "experiments" / "car_line.yaml").read_text(encoding="utf-8"))
SHORT = {"fit": LINE["operations"]["fit"] | {"seconds": 6}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("station")


@pytest.fixture(scope="module")
def document(folder: Path) -> dict[str, Any]:
    """What the command finds of the car line with a short operation."""
    (folder / "line.yaml").write_text(yaml.safe_dump(LINE | {"operations": SHORT, "ways": ["arm"]}))
    done = fatplan("assess", "line.yaml", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


def store(folder: Path) -> ReactionCache:
    return ReactionCache(folder / "cache")


def examined(folder: Path, **more: Any) -> Examined:
    return examine([station(**more)], store(folder), LocalProcesses(2), "fatplan assess", lambda _: None)[0]


def test_who_cannot_is_an_answer(document: dict[str, Any]) -> None:
    outcomes = document["outcomes"]
    assert len(outcomes) == 9
    missed = [each for each in outcomes if each["kind"] == "missed"]
    assert {(each["doing"]["worker"], each["doing"]["place"]) for each in missed} == {("small_woman", "overhead")}
    assert all(0.02 < each["missed_m"] < 0.15 for each in missed)
    first = document["headline"][0]
    assert first["key"].startswith("{worker} cannot reach {place}")
    assert first["text"].startswith("small_woman cannot reach overhead: the hand stays ")


def test_the_first_lines_say_what_counts(document: dict[str, Any]) -> None:
    text = "\n".join(each["text"] for each in document["headline"][:10])
    assert "fit at overhead is not acceptable for " in text and "ISO 11226" in text
    assert "Best for fit: door" in text and "The most tired joint is " in text
    assert document["best"]["places"] == {"fit": "door"}
    assert set(document["best"]["excluded"]) == {"fit/overhead", "fit/floor"}


def test_nothing_that_a_rule_forbids_is_recommended(document: dict[str, Any]) -> None:
    best = document["best"]["places"]["fit"]
    own = [each for each in document["places"] if each["place"] == best]
    assert len(own) == 3 and all(each["level"] != "not_acceptable" for each in own)
    levels = {each["place"]: each["level"] for each in document["summaries"]}
    assert levels["overhead"] == levels["floor"] == "not_acceptable"


def test_who_of_the_population_reaches(document: dict[str, Any]) -> None:
    shares = {(each["place"], each["sex"]): each for each in document["shares"]}
    overhead = shares["overhead", "female"]
    assert 1.525 < overhead["shortest_m"] < 1.7  # the small woman of 1.525 m does not
    assert overhead["share_low"] < overhead["share"] < overhead["share_high"] < shares["overhead", "male"]["share"]
    assert shares["door", "female"]["share"] == shares["door", "male"]["share"] == 1
    assert shares["floor", "female"]["strong_share"] < shares["floor", "male"]["strong_share"] < 1


@pytest.mark.parametrize("language", ["de", "en"])
def test_the_page_lies_beside_the_files(document: dict[str, Any], folder: Path, language: str) -> None:
    done = fatplan("assess", "line.yaml", "--language", language, cwd=folder)
    assert done.returncode == 0 and "assess.html" in done.stdout
    page = (folder / "results" / "car_line" / "assess.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and f'<html lang="{language}">' in page and len(page) < 3_000_000
    assert not any(name in page for name in document["station"]["workers"])
    places, tables = len([each for each in document["places"] if each["way"]]), page.count("<table")
    assert page.count("<svg") == places + 3  # those of the first side, one of each place, come again
    assert tables > 10 and document["station_digest"][:16] in page


def test_the_files_hold_the_same_and_a_second_run_too(document: dict[str, Any], folder: Path) -> None:
    results = folder / "results" / "car_line"
    written = json.loads((results / "assessment.json").read_text(encoding="utf-8"))
    assert written == {key: value for key, value in document.items() if key != "files"}
    with (results / "outcomes.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 9
    with (results / "indicators.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["worker"] for row in rows} == {"small_woman", "tall_man", "left_hander"}
    before = (results / "assessment.json").read_bytes()
    assert fatplan("assess", "line.yaml", "--jobs", "1", cwd=folder).returncode == 0
    assert (results / "assessment.json").read_bytes() == before


def test_operations_that_must_all_be_done_make_a_cycle(folder: Path) -> None:
    places = {
        "low": {"x": 0.35, "y": 0.0, "z": 1.1}, "high": {"x": 0.35, "y": 0.0, "z": 1.15},
        "roof": {"x": 0.4, "y": 0.0, "z": 2.9},
    }  # fmt: skip
    operations = {
        "one": {"places": ["low", "high"], "seconds": 2, "tool": "screwdriver"},
        "two": {"places": ["high"], "seconds": 2},
    }
    workers = {"woman": {"percentile": 50, "sex": "female"}, "weak": {"percentile": 50, "sex": "female"}}
    workers["weak"]["strength_percentile"] = 5
    found, cache = examined(folder, places=places, operations=operations, workers=workers, ways=["arm"]), store(folder)
    assert found.best.places == {} and found.best.together is not None  # an arm behind the body, 2.9 times a minute
    assert "EN 1005-4" in str(found.best.together) and not found.best.excluded
    slow = {
        "places": places,
        "operations": operations,
        "workers": workers,
        "ways": ["arm"],
        "cycle": {"duration_s": 90},
    }
    found = examined(folder, **slow)
    assert set(found.best.places) == {"one", "two"} and found.best.next_above is not None
    assert found.best.next_above >= 0
    cycles = whole_cycles(found, cache, "fatplan assess")
    by_worker = {cycle.worker: cycle for cycle in cycles}
    assert by_worker["weak"].fatigue.peak > by_worker["woman"].fatigue.peak > 0
    assert all(cycle.recommended and len(cycle.doings) == 2 for cycle in cycles)
    woman = by_worker["woman"]
    assert woman.fatigue.peak >= max(
        found.judged[doing].fatigue.peak for doing in woman.doings
    )  # less rest, more to do
    assert Level.ACCEPTABLE <= woman.level < Level.NOT_ACCEPTABLE
    rotation = best_rotation(found, cache, "fatplan assess")
    assert rotation is not None and 0 <= rotation.saving < 1 and rotation.sequence[0].keys() == {"one", "two"}
    roof = operations | {"three": {"places": ["roof"], "seconds": 2}}
    nowhere = examined(folder, places=places, operations=roof, workers=workers, ways=["arm"])
    assert nowhere.best.places == {} and whole_cycles(nowhere, cache, "fatplan assess") == ()
    assert ("three", "roof") in nowhere.best.excluded


def test_what_sensing_adds_lies_between_the_schedule_and_the_bound(folder: Path) -> None:
    places = {"low": {"x": 0.4, "y": -0.1, "z": 0.7}, "high": {"x": 0.35, "y": -0.1, "z": 1.5}}
    operations = {"one": {"places": ["low", "high"], "seconds": 12, "tool": "gun", "hand": "right"}}
    workers = {"woman": {"percentile": 50, "sex": "female"}}
    said = {"places": places, "operations": operations, "workers": workers, "cycle": {"duration_s": 20}}
    found, cache = examined(folder, **said, ways=["arm", "squat"], binding=[]), store(folder)
    scenario = scenario_of(found, "woman", cache, "fatplan assess")
    assert scenario.model.actions == ("0", "1") and scenario.model.outcomes == ("arm", "squat")
    # what a robot pays that always presents one place, from the motions alone: half of the cycles in each way
    gains, offsets = scenario.model.arrays.gain, scenario.model.arrays.offset
    rng, costs = np.random.default_rng(1), []
    for _ in range(2000):
        fatigue, cost = np.zeros(gains.shape[1]), 0.0
        for cycle in range(100):
            row = int(rng.integers(2))
            fatigue = gains[row] * fatigue + offsets[row]
            cost += DISCOUNT**cycle * float(np.sum(fatigue**2)) / len(ENTRIES)
        costs.append(cost)
    fixed = float(schedule_cost(start_of(scenario)).costs(np.array([[0]]))[0])
    assert fixed == pytest.approx(np.mean(costs), abs=4 * np.std(costs) / math.sqrt(len(costs)) + 0.01 * fixed)
    sensing = sensing_of(found, cache, "fatplan assess")
    assert sensing is not None and not sensing.certain and sensing == sensing_of(found, cache, "fatplan assess")
    assert sensing.low <= sensing.saving <= sensing.high and sensing.low <= sensing.most < 0.5
    # where a way may not be used, the worker takes the best one: nothing is left to see
    arm = {doing: judged for doing, judged in found.judged.items() if doing.way == "arm"}
    only = replace(found, judged=arm, places=[replace(each, way="arm") for each in found.places])
    forced = {doings for row in ways_of(only, "woman") for doings in row}
    best = {found.doings("woman", {"one": place}) for place in places}
    assert all(doings[0].way == "arm" or doings in best for doings in forced)
    single = examined(folder, **said, ways=["arm"], binding=[])
    assert sensing_of(single, cache, "fatplan assess") == Sensing(0.0, 0.0, 0.0, 0.0, certain=True)


def test_the_schedule_of_a_station_is_that_of_its_page(folder: Path) -> None:
    """Of places that are allowed, in the station's words; what is kept of the motions serves both."""
    said = LINE | {
        "name": "bench",
        "places": {name: {"x": 0.35, "y": 0.0, "z": z} for name, z in (("low", 1.1), ("high", 1.15), ("roof", 2.9))},
        "operations": {"one": {"places": ["low", "high", "roof"], "seconds": 2, "tool": "screwdriver"}},
        "ways": ["arm"],
        "cycle": {"duration_s": 90},
    }
    (folder / "bench.yaml").write_text(yaml.safe_dump(said, sort_keys=False))
    station_of_page = load_station(folder / "bench.yaml")
    found = examine([station_of_page], store(folder), LocalProcesses(2), "fatplan assess", lambda _: None)[0]
    rotation = best_rotation(found, store(folder), "fatplan assess")
    done = fatplan("schedule", "bench.yaml", "--json", cwd=folder)
    assert done.returncode == 0 and rotation is not None, done.stderr
    schedule = json.loads(done.stdout)
    assert schedule["places"] == list(map(dict, rotation.sequence)) and schedule["exact"] == rotation.exact
    assert schedule["schedule"] == [places["one"] for places in schedule["places"]]
    assert [each["condition"] for each in schedule["conditions"]] == list(LINE["workers"])
    assert schedule["left_out"] == ["roof is left out: small_woman, tall_man, left_hander cannot work there"]
    files = folder / "results" / "bench" / "schedule"
    assert {path.name for path in files.iterdir()} == {f"schedule_card.{kind}" for kind in ("csv", "png", "svg")}
    text = fatplan("schedule", "bench.yaml", "--conditions", "tall_man", "--longest", 1, cwd=folder).stdout
    assert "the best fixed place" in text and "small_woman" not in text and "novice" not in text
    card = (files / "schedule_card.svg").read_text(encoding="utf-8")
    assert "Man P95" in card and "tall" not in card
    (folder / "roof.yaml").write_text(
        yaml.safe_dump(said | {"operations": {"one": {"places": ["roof"], "seconds": 2}}})
    )
    refused = fatplan("schedule", "roof.yaml", cwd=folder)
    assert (
        refused.returncode == 2 and "roof.yaml: no place is allowed that a schedule could have: roof" in refused.stderr
    )


def test_the_guide_prints_what_the_program_does(tmp_path: Path) -> None:
    """The lines of docs/station.md, in their order, among the first ten that follow the workers."""
    guide = (ROOT / "docs" / "station.md").read_text(encoding="utf-8")
    lines = guide.partition("```text\n")[2].partition("```")[0].splitlines()
    printed = fatplan("assess", "car_line", cwd=tmp_path).stdout.splitlines()[1:11]
    patterns = [re.escape(line).replace("…", ".*") for line in lines]
    found = [next(i for i, said in enumerate(printed) if re.fullmatch(each, said.strip())) for each in patterns]
    assert len(found) == 5 and found == sorted(found)
    first = "\n".join(printed)
    for said in (
        "small_woman cannot reach overhead", "overhead is not acceptable for", "ISO 11226 (head leaning back, 25 s)",
        "Best for fit: door", "The most tired joint is",
    ):  # fmt: skip
        assert said in first, said


def test_a_limit_binds_and_says_so(folder: Path) -> None:
    places = {"low": {"x": 0.35, "y": 0.0, "z": 1.1}, "high": {"x": 0.35, "y": 0.0, "z": 1.15}}
    operations = {"one": {"places": ["low", "high"], "seconds": 2, "tool": "screwdriver"}}
    workers = {"woman": {"percentile": 50, "sex": "female"}}
    limits = [{"measure": "upper_arm_elevation", "above_deg": 5, "at_most_s": 1}]
    found = examined(folder, places=places, operations=operations, workers=workers, ways=["arm"], limits=limits)
    assert found.best.places == {} and found.judged == {}
    assert all(each.breaches[0].seconds > 2 for each in found.outcomes)
    said = headline_of(found.station, found.places, found.summaries, found.best, ())
    assert "breaks limit 1 of the station at low" in str(said[0])
    (none,) = bound_experiments(found.station, found.outcomes)
    assert none.experiment is None and "limit 1 allows 1 s" in none.left_out[1]


def test_changes_are_computed(folder: Path) -> None:
    places = {"high": {"x": 0.35, "y": 0.0, "z": 1.8}}
    operations = {"one": {"places": "high", "seconds": 2, "hand": "right", "tool": "gun"}}
    workers = {"woman": {"percentile": 5, "sex": "female"}}
    said = station(places=places, operations=operations, workers=workers, ways=["arm"])
    changed = changed_stations(said)
    stations = [said, *(each for _, each in changed)]
    found, *others = examine(stations, store(folder), LocalProcesses(2), "fatplan assess", lambda _: None)
    changes = changes_of([phrase for phrase, _ in changed], found, others)
    names = {str(each.change) for each in changes}
    assert names == {"gun 1 kg lighter", "high 10 cm lower", "high 10 cm nearer", "one with the other hand"}
    lower = next(each for each in changes if str(each.change) == "high 10 cm lower")
    assert (lower.reached_by_all, lower.of_places) == (1, 1)
    assert found.summaries[0].missed_by == ("woman",)
    for saving, said in (
        (0.27, "1 allowed, 27% less fatigue"),
        (-0.04, "1 allowed, 4% more fatigue"),
        (-0.004, "1 allowed, as much fatigue"),
        (None, "1 allowed"),
    ):
        (phrase,) = of_changes([replace(lower, allowed=1, saving_everywhere=saving)], found.best)
        assert str(phrase).endswith(said)

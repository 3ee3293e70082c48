"""What becomes of a motion, without simulating: real motions with other measures, and places where no hand can be."""

from dataclasses import replace

import pytest
from test_station_file import station

from fatigue_planner.cli.assess import capped
from fatigue_planner.core.executors.processes import LocalProcesses
from fatigue_planner.ergonomics.result import Phrase
from fatigue_planner.motion.causes import TRIALS
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Quality
from fatigue_planner.reactions.cache import Outcome as Simulated
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.station import population_reach
from fatigue_planner.station.outcomes import Task, classified, simulate_all, tasks_of
from fatigue_planner.station.population_reach import Question, answered, emptied, questions
from fatigue_planner.station.statements import MISSED_FAR, NO_JOINT, of_population


@pytest.fixture(scope="module")
def task() -> Task:
    return next(task for task in tasks_of(station()) if task.doing[:3] == ("tall_man", "fit", "overhead"))


@pytest.fixture(scope="module")
def good(reactions: tuple[Reaction, ...]) -> Quality:
    """A quality without any finding."""
    quality = reactions[0].quality
    measures = {name: 0.0 for name, value in vars(quality.plausibility).items() if isinstance(value, float)}
    return replace(quality, plausibility=replace(quality.plausibility, **measures), foot_displacement_m=0.0)


def outcome_of(task: Task, quality: Quality | None, failure: str = "") -> Simulated:
    return Simulated.of(task.request, quality, failure)


def test_a_hand_on_its_place_has_reached_it(task: Task, good: Quality) -> None:
    reached = classified(task, outcome_of(task, good))
    assert (reached.kind, reached.usable, reached.missed_m) == ("reached", True, None)
    rough = replace(good, plausibility=replace(good.plausibility, torque_step_nm=11.0))
    assert classified(task, outcome_of(task, rough)).kind == "reached"  # not smooth, but so it could be
    twisted = replace(good, plausibility=replace(good.plausibility, trunk_twist_deg=40.0))
    odd = classified(task, outcome_of(task, twisted))
    assert (odd.kind, odd.usable) == ("implausible", False)
    assert [finding.measure for finding in odd.findings] == ["trunk_twist_deg"]


def test_a_hand_off_its_place_misses_it_or_is_too_weak(task: Task, good: Quality) -> None:
    away = replace(good, work_hand_error_m=0.061, saturated_share=0.5, saturated_joint="right_shoulder_flexion")
    far = replace(away, tested_causes=f"it works {TRIALS['place']}; it fails {TRIALS['load']}")
    missed = classified(task, outcome_of(task, far))
    assert (missed.kind, missed.missed_m, missed.joint) == ("missed", 0.061, "")
    heavy = replace(away, tested_causes=f"it works {TRIALS['load']}: make it lighter; it fails {TRIALS['speed']}")
    weak = classified(task, outcome_of(task, heavy))
    assert (weak.kind, weak.joint, weak.missed_m) == ("too_weak", "right_shoulder_flexion", None)
    broken = (
        f"no admissible movement; left_knee_flexion at its maximum torque 33% of the time. It works {TRIALS['place']}"
    )
    assert classified(task, outcome_of(task, None, broken)).kind == "missed"
    broken = f"no way; left_knee_flexion at its maximum torque 33%. Tried again, it works {TRIALS['load']}"
    fallen = classified(task, outcome_of(task, None, broken))
    assert (fallen.kind, fallen.joint) == ("too_weak", "left_knee_flexion")
    turned = replace(good, work_hand_turn_rad=0.2)
    assert classified(task, outcome_of(task, turned)).kind == "missed"
    slid = replace(good, foot_displacement_m=0.02)
    assert classified(task, outcome_of(task, slid)).kind == "implausible"


def test_where_no_hand_can_be_nothing_is_simulated(tmp_path) -> None:  # type: ignore[no-untyped-def]
    places = {
        "roof": {"x": 0.4, "y": 0.0, "z": 2.9}, "chest": {"x": 0.01, "y": 0.0, "z": 1.3},
        "ground": {"x": 0.5, "y": 0.0, "z": 0.04},
    }  # fmt: skip
    said = station(places=places, operations={"fit": {"places": list(places), "seconds": 5}}, ways=["arm"])
    tasks = tasks_of(said)
    outcomes = simulate_all(tasks, ReactionCache(tmp_path), LocalProcesses(1), lambda _: None)
    found = {outcome.doing.place: outcome for outcome in outcomes if outcome.doing.worker == "tall_man"}
    assert {place: outcome.kind for place, outcome in found.items()} == {
        "roof": "missed", "chest": "implausible", "ground": "implausible",
    }  # fmt: skip
    assert found["roof"].missed_m is not None and 0.3 < found["roof"].missed_m < 0.9
    assert "of the standing worker" in found["chest"].detail and "in the floor" in found["ground"].detail
    assert list(tmp_path.iterdir()) == []


def test_a_load_that_is_too_heavy_is_no_matter_of_reach(
    reactions: tuple[Reaction, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Statures from 1.55 m on reach the place; what they can bear there is a share of the strong, or of nobody."""
    asked: list[tuple[bool, float, float]] = []
    bears = 50.0

    def reaching(question: Question, stature: float, strength: float = 50.0) -> Motion | None:
        asked.append((question.is_loaded, stature, strength))
        can = stature >= 1.55 and (not question.is_loaded or strength >= bears)
        return reactions[0].motion if can else None

    monkeypatch.setattr(population_reach, "_reaching", reaching)
    question = next(each for each in questions(station()) if (each.place, each.sex) == ("overhead", "female"))
    able = answered(question)
    assert able.shortest_m == pytest.approx(1.55, abs=0.005) and 0.8 < able.share < 1
    assert all(loaded and strength == 50 for loaded, _, strength in asked)
    for bears, weakest in ((99.0, able.weakest_joint), (100.0, "")):  # noqa: B007 - read by `reaching`
        asked.clear()
        found = answered(question)
        assert (found.share, found.shortest_m) == (able.share, able.shortest_m)
        assert found.weakest_joint == weakest and (found.strong_share == 0) == (weakest == "")
        assert len([each for each in asked if each[0]]) == 2  # the median and the strongest: failing takes long
        said = [str(phrase) for phrase in of_population([found])]
        assert "overhead is reached by" in said[0] and "strong enough for overhead" in said[1]
        assert said[1].startswith("Nobody") == (weakest == "")
    assert answered(replace(question, station=emptied(question.station))).share == able.share


def test_the_terminal_shows_the_first_lines_of_a_kind() -> None:
    many = [Phrase(MISSED_FAR, {"worker": "anna", "place": f"rack_{i}"}) for i in range(100)]
    lines = list(capped([*many, Phrase(NO_JOINT)]))
    assert lines[:2] == ["  anna cannot reach rack_0.", "  anna cannot reach rack_1."]
    assert lines[-2:] == ["  … and 94 more of this kind, see assess.html.", "  No joint tires."] and len(lines) == 8
    assert len(list(capped(many[:6]))) == 6

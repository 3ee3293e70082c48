"""ISO 11226 and EN 1005-4: holding times, known postures, a second computation at every tick, supports, frequency."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plain_iso import en_levels, iso_levels
from second_reading import readings
from test_posture import standing

from fatigue_planner.ergonomics.held_posture import HeldPosture
from fatigue_planner.ergonomics.indicators.en_1005_4 import En10054
from fatigue_planner.ergonomics.indicators.iso_11226 import HEAD, TRUNK, UPPER_ARM, Iso11226, Line, arm_hold
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.result import Assessment, Level
from fatigue_planner.ergonomics.stated import Circumstances, Shift
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.motion.motion import Motion, Phase
from fatigue_planner.reactions.reaction import Reaction

HIPS = ("right_hip_flexion", "left_hip_flexion")


def one(indicator: HeldPosture, operation: Operation, **shift: float) -> Assessment:
    return evaluate([operation], Shift(**shift), [indicator])[0]


def all_work(motion: Motion, **changes: Any) -> Motion:
    """A motion that is work from its first tick to its last."""
    changed = replace(motion, **changes)
    ticks = len(changed.configuration)
    return replace(changed, phases=(Phase("reach", 0, 0), Phase("work", 0, ticks), Phase("return", ticks, ticks)))


@pytest.mark.parametrize(
    ("line", "angle_deg", "expected_s"),
    [
        # the corners of the lines, read in two sources
        (TRUNK, 20.001, 240), (TRUNK, 60, 60), (HEAD, 25.001, 480), (HEAD, 85, 60), (UPPER_ARM, 20.001, 180),
        (UPPER_ARM, 60, 60),
        # computed from the lines
        (TRUNK, 40, 150), (UPPER_ARM, 40, 120), (HEAD, 55, 270),
        (TRUNK, 20, np.inf), (TRUNK, 61, 0), (UPPER_ARM, 61, 0), (HEAD, 86, 0),
    ],
)  # fmt: skip
def test_holding_times(line: Line, angle_deg: float, expected_s: float) -> None:
    assert line.holding_s(np.array([angle_deg]))[0] == pytest.approx(expected_s, abs=0.01)


@pytest.mark.slow
def test_a_second_computation_finds_the_same_at_every_tick(reactions: tuple[Reaction, ...]) -> None:
    for reaction in reactions:
        operation = Operation.of(reaction, Circumstances(shoulder_raised=False), step_s=0)
        seen = list(readings(reaction, 1).values())
        for indicator, again in ((Iso11226(), iso_levels), (En10054(), en_levels)):
            work = reaction.motion.phase("work")
            at_work = [work.start <= tick < work.stop for tick in range(len(seen))]
            expected = again(seen, operation.posture.step_s, at_work)
            job_times = one(indicator, operation).times
            assert job_times is not None
            counted = [expected.count(level) * operation.posture.step_s for level in range(3)]
            np.testing.assert_allclose(job_times, counted, atol=1e-9, err_msg=f"{reaction.name} {indicator.kind}")
            rules = indicator.judged(Job([operation]), [operation.stated])[0]
            assert np.max([rule.level for rule in rules], axis=0).tolist() == expected, f"{reaction.name}"


@pytest.mark.parametrize(
    ("posture", "stated", "iso", "en", "part"),
    [
        ({}, {}, Level.ACCEPTABLE, Level.ACCEPTABLE, ""),
        (dict.fromkeys(HIPS, 15.0) | {"neck_flexion": 5.0}, {}, Level.ACCEPTABLE, Level.ACCEPTABLE, ""),
        # 16 s at 40 degrees, where 150 s are allowed; the neck makes up for it
        (dict.fromkeys(HIPS, 40.0) | {"neck_flexion": -4.0}, {}, Level.INVESTIGATE, Level.INVESTIGATE, ""),
        (dict.fromkeys(HIPS, 38.0), {"trunk_supported": True}, Level.ACCEPTABLE, Level.ACCEPTABLE, ""),
        (dict.fromkeys(HIPS, 65.0), {}, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE, "trunk inclined"),
        (dict.fromkeys(HIPS, -10.0), {}, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE, "trunk leaning back"),
        ({"neck_flexion": 30.0}, {}, Level.NOT_ACCEPTABLE, Level.ACCEPTABLE, "neck flexed"),
        ({"neck_rotation": 40.0}, {}, Level.ACCEPTABLE, Level.ACCEPTABLE, ""),
        ({"neck_rotation": 50.0}, {}, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE, "neck twisted"),
        ({"neck_lateral": 12.0}, {}, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE, "neck bent sideways"),
        ({"right_shoulder_flexion": 50.0}, {}, Level.INVESTIGATE, Level.INVESTIGATE, ""),
        ({"right_shoulder_flexion": 50.0}, {"arm_supported": True}, Level.ACCEPTABLE, Level.ACCEPTABLE, ""),
        ({"left_shoulder_flexion": 50.0}, {"arm_supported": True}, Level.INVESTIGATE, Level.INVESTIGATE, ""),
        ({"right_shoulder_flexion": 70.0}, {}, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE, "right upper arm raised"),
        ({"left_shoulder_flexion": -15.0}, {}, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE, "left upper arm behind"),
        ({"left_wrist_deviation": 18.0}, {}, Level.NOT_ACCEPTABLE, Level.ACCEPTABLE, "left wrist deviated"),
        ({}, {"shoulder_raised": True}, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE, "right shoulder raised"),
    ],
)
def test_postures_that_are_held(
    paper: Experiment,
    reactions: tuple[Reaction, ...],
    posture: dict[str, float],
    stated: dict[str, bool],
    iso: Level,
    en: Level,
    part: str,
) -> None:
    """A posture of 16 s; the arms of who is bent hang down to the floor and are not raised."""
    hanging = {f"{side}_shoulder_flexion": posture[HIPS[0]] for side in ("right", "left") if HIPS[0] in posture}
    motion = standing(paper, reactions[0].motion, **hanging | posture)
    circumstances = Circumstances.model_validate({"shoulder_raised": False} | stated)
    operation = replace(Operation.of(reactions[0], circumstances), motion=motion)
    found = one(Iso11226(), operation)
    assert found.levels == (iso, iso), found.parts
    levels_of_en = one(En10054(), operation, cycle_s=600).levels
    assert levels_of_en is not None
    assert levels_of_en[0] == en
    assert any(name.startswith(part) for name in found.parts) or not part, found.parts
    assert (found.value == (0, 0)) == (iso < Level.NOT_ACCEPTABLE)


def test_a_hold_that_uses_up_its_time_is_not_acceptable(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """An arm at 50 degrees may be held for 90 s: 16 s are for a while, 96 s are too long."""
    motion = standing(paper, reactions[0].motion, right_shoulder_flexion=50.0)
    operation = Operation.of(reactions[0], Circumstances(shoulder_raised=False))
    short = one(Iso11226(), replace(operation, motion=motion))
    longer = one(Iso11226(), replace(operation, motion=replace(motion, time_step_s=0.06)))
    assert (short.times, short.value) == ((0, 16, 0), (0, 0))
    assert longer.times == pytest.approx((0, 0, 96))
    assert longer.parts == {"right upper arm raised": pytest.approx(96)}


def test_a_brief_rise_is_no_rest(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """50 degrees for 80 s, 62 for 3 s, 50 for 77 s is one hold of 160 s; with the arm down in between, it is two."""
    at = {
        degrees: standing(paper, reactions[0].motion, right_shoulder_flexion=degrees).configuration
        for degrees in (50.0, 62.0, 0.0)
    }
    for between, expected in ((62.0, (0, 0, 160)), (0.0, (3, 157, 0))):
        configuration = np.vstack([at[50.0][:800], at[between][:30], at[50.0][:770]])
        motion = all_work(reactions[0].motion, configuration=configuration, time_step_s=0.1)
        operation = replace(Operation.of(reactions[0], Circumstances(shoulder_raised=False)), motion=motion)
        assert one(Iso11226(), operation).times == pytest.approx(expected)


def test_what_passes_is_not_held(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """An arm above 60 degrees for 4 s passes; for 4.1 s it is held."""
    up, down = (
        standing(paper, reactions[0].motion, right_shoulder_flexion=degrees).configuration for degrees in (75.0, 0.0)
    )
    for ticks, expected_s in ((400, 0.0), (410, 4.1)):
        motion = all_work(reactions[0].motion, configuration=np.vstack([up[:ticks], down[ticks:]]))
        operation = replace(Operation.of(reactions[0], Circumstances(shoulder_raised=False)), motion=motion)
        assert one(Iso11226(), operation).value == pytest.approx((expected_s, expected_s))
        hold = arm_hold(replace(reactions[0], motion=motion))
        assert (hold.longest_s, hold.overhead) == (pytest.approx(ticks / 100), ticks > 400)
        assert hold.highest_deg == pytest.approx(75)


def test_the_ways_are_movements(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """An arm above 60 degrees from 2 s before the work to 2 s after it is held for the 6 s of the work, not for 10 s.

    Whoever never lowers it holds it all the time.
    """
    up, down = (
        standing(paper, reactions[0].motion, right_shoulder_flexion=degrees).configuration for degrees in (75.0, 0.0)
    )
    work = reactions[0].motion.phase("work")
    first, last = work.start - 200, work.stop + 200
    part = np.vstack([down[:first], up[first:last], down[last:]])
    for configuration, expected_s in ((part, 6.0), (up, 16.0)):
        motion = replace(reactions[0].motion, configuration=configuration)
        operation = replace(Operation.of(reactions[0], Circumstances(shoulder_raised=False)), motion=motion)
        assert one(Iso11226(), operation).value == pytest.approx((expected_s, expected_s))
        assert one(En10054(), operation, cycle_s=60).value == pytest.approx((expected_s, expected_s))


def test_en_knows_no_movement_in_what_is_never_left(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """A trunk at 40 degrees through all cycles is held, conditionally; raised in each of them, it moves too often."""
    posture = dict.fromkeys((*HIPS, "right_shoulder_flexion", "left_shoulder_flexion"), 40.0) | {"neck_flexion": -4.0}
    bent, upright = (standing(paper, reactions[0].motion, **each).configuration for each in (posture, {}))
    raised = np.vstack([upright[:100], bent[100:]])
    for configuration, expected in ((bent, Level.INVESTIGATE), (raised, Level.NOT_ACCEPTABLE)):
        motion = replace(reactions[0].motion, configuration=configuration)
        operation = replace(Operation.of(reactions[0], Circumstances(shoulder_raised=False)), motion=motion)
        assert one(En10054(), operation, cycle_s=16).levels == ((expected,) * 2)


def test_en_counts_how_often_a_zone_is_entered(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """3 s above 60 degrees, once a cycle: conditional in a cycle of a minute, not acceptable in one of 16 s."""
    up, down = (
        standing(paper, reactions[0].motion, right_shoulder_flexion=degrees).configuration for degrees in (75.0, 0.0)
    )
    motion = replace(reactions[0].motion, configuration=np.vstack([down[:500], up[500:800], down[800:]]))
    operation = replace(Operation.of(reactions[0], Circumstances(shoulder_raised=False)), motion=motion)
    assert one(En10054(), operation, cycle_s=60).times == pytest.approx((13, 3, 0))
    assert one(En10054(), operation).times == pytest.approx((13, 0, 3))
    twice = replace(operation, stated=Circumstances(shoulder_raised=False, times_per_cycle=2))
    assert one(En10054(), twice, cycle_s=60).times == pytest.approx((26, 0, 6))


@pytest.mark.parametrize("seconds", [3.9, 5.0])
def test_en_judges_a_hold_by_how_often_it_is_entered_too(
    paper: Experiment, reactions: tuple[Reaction, ...], seconds: float
) -> None:
    """A trunk at 40 degrees 3 times a minute is not acceptable, and does not get better if it is held there."""
    posture = dict.fromkeys((*HIPS, "right_shoulder_flexion", "left_shoulder_flexion"), 40.0) | {"neck_flexion": -4.0}
    bent, upright = (standing(paper, reactions[0].motion, **each).configuration for each in (posture, {}))
    ticks = round(100 * seconds)
    configuration = np.vstack([upright[:500], bent[:ticks], upright[500 + ticks :]])
    motion = all_work(reactions[0].motion, configuration=configuration)
    operation = replace(Operation.of(reactions[0], Circumstances(shoulder_raised=False)), motion=motion)
    assert one(En10054(), operation, cycle_s=20).times == pytest.approx((16 - seconds, 0, seconds))
    assert one(En10054(), operation, cycle_s=60).levels == ((Level(seconds > 4),) * 2)


def test_en_counts_one_movement_through_a_zone_and_back_once(
    paper: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    """An arm goes to 75 degrees by way of 50 and back: 1.5 times a minute is seldom, twice that would not be."""
    high, middle, low = (
        standing(paper, reactions[0].motion, right_shoulder_flexion=degrees).configuration
        for degrees in (75.0, 50.0, 0.0)
    )
    parts = [low[:500], middle[:100], high[:200], middle[:100], low[:700]]
    motion = replace(reactions[0].motion, configuration=np.vstack(parts))
    operation = replace(Operation.of(reactions[0], Circumstances(shoulder_raised=False)), motion=motion)
    assert one(En10054(), operation, cycle_s=40).times == pytest.approx((14, 2, 0))
    assert one(En10054(), operation, cycle_s=20).times == pytest.approx((12, 2, 2))


def test_a_raised_shoulder_is_asked_for(reactions: tuple[Reaction, ...]) -> None:
    """high/arm: what is not acceptable grows to all of the work, 6 s, beside what is so already."""
    found = one(Iso11226(), Operation.of(reactions[0]))
    assert found.value is not None
    assert [decides.key for decides in found.decides] == ["shoulder_raised"]
    assert found.value.high >= 6 > found.value.low
    assert found.text() == f"{found.value.low:.1f} s ({found.value.high:.1f} with a raised shoulder)"

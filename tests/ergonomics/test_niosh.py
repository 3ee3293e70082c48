"""The NIOSH lifting equation: tables and published examples, lifts of simulated operations, what it refuses."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fatigue_planner.ergonomics.indicators.niosh_lifting import NioshLifting, lift_of
from fatigue_planner.ergonomics.lifting_equation import (
    DURATIONS,
    METRIC,
    Lift,
    Place,
    Units,
    composite_index,
    duration_class,
    frequency_multiplier,
    multipliers,
)
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.result import Assessment, Level
from fatigue_planner.ergonomics.stated import Circumstances, Shift
from fatigue_planner.motion.action import Action, HandGoal, Position
from fatigue_planner.reactions.reaction import Reaction

# lb and inches, as in the manual's examples.
US = Units(51, 10, 25, 30, 0.0075, 70, 1.8, 10, 70)
# Table 5 as in nbarr1/ErgonomicTool, methods/rnle/transcription/table-5-frequency-multiplier.reconciled.csv.
TABLE_5 = """
.2 1.00 1.00 .95 .95 .85 .85|.5 .97 .97 .92 .92 .81 .81|1 .94 .94 .88 .88 .75 .75|2 .91 .91 .84 .84 .65 .65
3 .88 .88 .79 .79 .55 .55|4 .84 .84 .72 .72 .45 .45|5 .80 .80 .60 .60 .35 .35|6 .75 .75 .50 .50 .27 .27
7 .70 .70 .42 .42 .22 .22|8 .60 .60 .35 .35 .18 .18|9 .52 .52 .30 .30 .00 .15|10 .45 .45 .26 .26 .00 .13
11 .41 .41 .00 .23 .00 .00|12 .37 .37 .00 .21 .00 .00|13 .00 .34 .00 .00 .00 .00|14 .00 .31 .00 .00 .00 .00
15 .00 .28 .00 .00 .00 .00
"""
STATED: dict[str, Any] = {"handling": "lift", "coupling": "fair", "placed_carefully": False, "end_height_m": 1.4}


def test_the_frequency_table_is_that_of_another_transcription() -> None:
    for row in TABLE_5.replace("|", "\n").split("\n")[1:-1]:
        per_minute, *values = map(float, row.split())
        found = [frequency_multiplier(per_minute, one, high) for one in DURATIONS for high in (False, True)]
        assert found == pytest.approx(values), row
    assert frequency_multiplier(0.05, "long", False) == 0.85
    assert frequency_multiplier(1.5, "long", False) == pytest.approx(0.70)
    assert [frequency_multiplier(15.01, one, True) for one in DURATIONS] == [0, 0, 0]


def product(place: Place, travel: float, coupling: Any, fm: float, units: Units, digits: int | None = None) -> float:
    factors = [*multipliers(place, travel, coupling, units).values(), fm]
    return units.load * math.prod(factors if digits is None else [round(factor + 1e-9, digits) for factor in factors])


def test_package_inspection() -> None:
    """Example 4 of the manual: printed with multipliers of two decimals; in full precision its last digit differs."""
    fm = frequency_multiplier(3, "short", False)
    origin, destination = Place(10, 22, 0), Place(20, 59, 0)
    assert [round(product(place, 37, "fair", fm, US, 2), 1) for place in (origin, destination)] == [34.9, 15.2]
    assert [round(product(place, 37, "fair", fm, US), 1) for place in (origin, destination)] == [34.8, 15.3]
    lift = Lift(26, origin, None, 37, "fair", 3)
    assert round(composite_index([lift], "short", US), 1) == 0.7
    assert round(composite_index([lift._replace(destination=destination)], "short", US), 1) == 1.7


def test_metric_examples() -> None:
    """From the tests of ErgoCapture, and an example of ErgoCalculator, whose load constant is Europe's 25 kg."""
    fm = frequency_multiplier(1, "moderate", False)
    assert product(Place(40, 30, 0), 60, "fair", fm, METRIC) == pytest.approx(9.30, abs=0.005)
    found = multipliers(Place(24, 33, 0), 82, "poor")
    assert (found["HM"], found["VM"], round(found["DM"], 4)) == (1, pytest.approx(0.874), 0.8749)
    lift = Lift(7, Place(24, 33, 0), None, 82, "poor", 1)
    assert round(composite_index([lift], "short", METRIC._replace(load=25)), 4) == 0.4328


def test_three_tasks_of_the_manual() -> None:
    """Section 2.4.5 (recalled): 30, 20, 10 lb at 1, 2, 4 lifts/min, FIRWL 20, 20, 15 lb: STLI 1.6, 1.1, .8; CLI 1.9."""

    class Given(Lift):
        def independent_limit(self, units: Units = METRIC) -> float:
            return {30: 20.0, 20: 20.0, 10: 15.0}[int(self.load)]

    tasks = [Given(load, Place(10, 20, 0), None, 10, "good", f) for load, f in ((30.0, 1.0), (20.0, 2.0), (10.0, 4.0))]
    assert [round(composite_index([task], "short", US), 1) for task in tasks] == [1.6, 1.1, 0.8]
    for order in (tasks, tasks[::-1], [tasks[1], tasks[2], tasks[0]]):
        assert round(composite_index(order, "short", US), 1) == 1.9


def test_duration_and_frequency_of_the_manual() -> None:
    minutes = [
        ([(30, 10), (45, 0)], "moderate"), ([(30, 30), (45, 0)], "short"), ([(120, 36), (120, 0)], "moderate"),
        ([(120, 35), (60, 0)], "long"), ([(60, 60), (60, 0)], "short"), ([(300, 30), (170, 0)], "long"),
        ([(300, 30), (190, 0)], None),
    ]  # fmt: skip
    for sessions, expected in minutes:
        assert duration_class([(work / 60, rest / 60) for work, rest in sessions]) == expected, sessions
    assert round(10 * 8 / 15, 2) == 5.33
    assert frequency_multiplier(10 * 8 / 15, "short", False) == pytest.approx(0.80 - 0.05 / 3)


def test_where_no_load_is_recommended() -> None:
    ends = [(Place(64, 75, 0), 25), (Place(25, 176, 0), 25), (Place(25, 75, 0), 176), (Place(25, 75, 136), 25)]
    for place, travel in ends:
        assert composite_index([Lift(1, place, None, travel, "good", 0.2)], "short") == math.inf
    assert composite_index([Lift(1, Place(25, 75, 0), None, 25, "good", 16)], "short") == math.inf
    assert multipliers(Place(20, 75, 0), 10, "good") == {"HM": 1, "VM": 1, "DM": 1, "AM": 1, "CM": 1}


def lifting(reaction: Reaction, **stated: Any) -> Operation:
    """The paper's motion as if both hands had a goal, so that the middle of the fists is what is lifted."""
    goal = HandGoal(position_m=Position(x=0.4, y=0.1, z=1.0))
    operation = Operation.of(reaction, Circumstances(**STATED | stated))
    action = Action(right_hand=goal, left_hand=goal)
    return replace(operation, request=replace(operation.request, action=action))


def one(*operations: Operation, **shift: float) -> Assessment:
    return evaluate(operations, Shift(**shift), [NioshLifting()])[0]


def test_a_simulated_lift(reactions: tuple[Reaction, ...]) -> None:
    """H, V and A from the first instant of the work, as MuJoCo's sum by hand; frequency and duration from the shift."""
    operation = lifting(reactions[0])
    found = one(operation, cycle_s=60, hours=1.5)
    start = reactions[0].motion.phase("work").start // 10
    middle = operation.posture.hand_m[start].mean(axis=0)
    away = middle - operation.posture.ankles_m[start]
    horizontal, angle = 100 * math.hypot(away[0], away[1]), abs(math.degrees(math.atan2(away[1], away[0])))
    travel = abs(140 - 100 * middle[2])
    factors = [25 / max(25, horizontal), 1 - 0.003 * abs(100 * middle[2] - 75), 0.82 + 4.5 / max(25, travel)]
    limit = 23 * math.prod(factors) * (1 - 0.0032 * angle) * 0.88 * (1.0 if middle[2] >= 0.75 else 0.95)
    assert found.value is not None
    assert found.value.low == found.value.high == pytest.approx(5 / limit)
    assert found.levels == (Level.ACCEPTABLE, Level.ACCEPTABLE)
    assert found.worst is not None
    assert found.worst.time_s == pytest.approx(5.0)


def test_what_is_not_stated_makes_a_range(reactions: tuple[Reaction, ...]) -> None:
    unknown = lifting(reactions[0], coupling=None, placed_carefully=None, end_height_m=None)
    found = one(unknown, cycle_s=60)
    assert found.value is not None
    assert {decides.key for decides in found.decides} >= {"hours", "coupling", "end_height_m"}
    mild = one(lifting(reactions[0], coupling="good", end_height_m=None), cycle_s=60, hours=1)
    assert mild.value is not None
    assert mild.value.low == found.value.low
    assert found.value.high > max(decides.value for decides in found.decides)
    assert found.plain()["levels"] == [level.words for level in found.levels or ()]


def test_the_way_decides_where_a_load_is_placed_with_care(reactions: tuple[Reaction, ...]) -> None:
    """Where the height is not stated, it is the height of the origin, and so far up or down, within the equation."""
    for handling, sign in (("lift", 1), ("lower", -1)):
        operation = lifting(reactions[0], handling=handling, end_height_m=None, placed_carefully=True)
        for way_m in (0.25, 1.75):
            found = lift_of(operation, Job([operation]), {"end_height_m": way_m})
            assert found.destination is not None
            expected = min(max(found.origin.height + sign * 100 * way_m, 0), 175)
            assert (found.destination.height, found.travel) == (pytest.approx(expected), 100 * way_m)


def test_the_last_spell_of_a_shift_may_be_shorter(reactions: tuple[Reaction, ...]) -> None:
    """7.5 h in spells of 4.5 h are one of 4.5 and one of 3; 2.5 h in spells of 1 with 1 h between are short."""
    operation = lifting(reactions[0])
    long, short = one(operation, cycle_s=60, hours=8), one(operation, cycle_s=60, hours=1)
    assert long.value != short.value
    assert one(operation, cycle_s=60, hours=7.5, spell_h=4.5, break_h=0.5).value == long.value
    assert one(operation, cycle_s=60, hours=2.5, spell_h=1, break_h=1).value == short.value
    # the longest time of work is an hour and has the longest break after it; the two before it have none
    unlike = [{"work_h": 0.8, "break_h": 0.1}, {"work_h": 0.7, "break_h": 1.5}, {"work_h": 1, "break_h": 1}]
    moderate = evaluate([operation], Shift(cycle_s=60, hours=2.5, spells=[*unlike]), [NioshLifting()])[0]
    assert moderate.value == one(operation, cycle_s=60, hours=1.5).value != short.value


def test_several_lifts_are_composed(reactions: tuple[Reaction, ...]) -> None:
    single = one(lifting(reactions[0]), cycle_s=60, hours=1)
    both = one(lifting(reactions[0]), lifting(reactions[1], load_kg=2.0), cycle_s=60, hours=1)
    assert single.value is not None
    assert both.value is not None
    assert both.value.low > single.value.low
    twice = one(lifting(reactions[0], times_per_cycle=2), cycle_s=60, hours=1)
    assert twice.value is not None
    assert twice.value.low == pytest.approx(single.value.low * 0.94 / 0.91)


@pytest.mark.parametrize(
    ("stated", "shift", "reason"),
    [
        ({"handling": "none"}, {}, "nothing is lifted or lowered"),
        ({"handling": "carry"}, {}, "nothing is lifted or lowered"),
        ({}, {"hours": 9.0}, "more than 8 h of lifting"),
        ({"load_kg": 0.0}, {"hours": 1.0}, "the lifted load is not known"),
    ],
)
def test_what_the_equation_refuses(
    reactions: tuple[Reaction, ...], stated: dict[str, Any], shift: dict[str, float], reason: str
) -> None:
    found = one(lifting(reactions[0], **stated), **shift)
    assert (found.applies, str(found.reason)) == (False, reason)
    assert found.text() == f"does not apply: {reason}"
    assert found.value is None


def test_one_hand_fast_hands_and_carrying_are_refused(reactions: tuple[Reaction, ...]) -> None:
    assert str(one(Operation.of(reactions[0], Circumstances(**STATED))).reason).startswith("one hand lifts")
    carrying = Operation.of(reactions[1], Circumstances(handling="carry"))
    assert "carried" in str(one(lifting(reactions[0]), carrying).reason)
    operation = lifting(reactions[0])
    configuration = operation.motion.configuration.copy()
    configuration[600:610, 0] += np.linspace(0, 0.4, 10)
    configuration[610:, 0] += 0.4
    fast = replace(operation, motion=replace(operation.motion, configuration=configuration))
    assert str(one(fast).reason) == "the hands are faster than 0.762 m/s"

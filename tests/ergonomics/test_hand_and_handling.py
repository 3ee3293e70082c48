"""Liberty Mutual, the strain index and DUET: transcriptions, published examples, operations of a motion."""

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from test_niosh import lifting

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.indicators.cumulative_strain_index import CumulativeStrainIndex
from fatigue_planner.ergonomics.indicators.duet import DAMAGE, Duet, probability
from fatigue_planner.ergonomics.indicators.lm_mmh import LibertyMutual
from fatigue_planner.ergonomics.indicators.strain_index import StrainIndex
from fatigue_planner.ergonomics.liberty_mutual import EQUATIONS, Kind
from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.result import Assessment, Level
from fatigue_planner.ergonomics.stated import Circumstances, OtherWork, Shift
from fatigue_planner.ergonomics.strain_equation import (
    Effort,
    Task,
    composite_index,
    cumulative_index,
    duration_multiplier,
    frequency_multiplier,
    hours_multiplier,
    intensity_multiplier,
    posture_multiplier,
    strain_index,
)
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.motion.action import Action
from fatigue_planner.reactions.reaction import Reaction

# Potvin et al. 2021 as in nbarr1/ErgonomicTool, methods/lm-mmh/transcription/equation-terms.pass-a.csv: reference load,
# the two or three factors in the order H or V, VRM, DV or DH, F, and the coefficient of variation.
TERMS = {
    ("lift", "female"): "34.9|1.2602-H/0.7686|0.9877+H/13.69-H^2/9.221|0.8199-L/7.696|0.6767-L/12.59-L^2/228.2|.260",
    ("lift", "male"): "82.6|1.3532-H/0.7079|0.7746+H/1.912-H^2/3.296|0.8695-L/10.62|0.6259-L/9.092-L^2/125.0|.276",
    ("lower", "female"): "37.0|1.2602-H/0.7686|0.9877+H/13.69-H^2/9.221|0.8199-L/7.696|0.6767-L/12.59-L^2/228.2|.307",
    ("lower", "male"): "95.9|1.3532-H/0.7079|0.7746+H/1.912-H^2/3.296|0.8695-L/10.62|0.5773-L/10.80-L^2/255.9|.304",
    ("push initial", "female"): "36.9|-0.5304+H/0.3361-H^2/0.6915||1.0286-H/72.22+H^2/9782|"
    "0.7251-L/13.19-L^2/197.3|.214",
    ("pull initial", "female"): "36.9|-0.5304+H/0.3361-H^2/0.6915||1.0286-H/72.22+H^2/9782|"
    "0.7251-L/13.19-L^2/197.3|.234",
    ("push sustained", "female"): "25.5|-0.6539+H/0.2941-H^2/0.5722||1.0391-H/52.91+H^2/7975|"
    "0.6086-L/11.95-L^2/304.4|.286",
    ("pull sustained", "female"): "25.5|-0.6539+H/0.2941-H^2/0.5722||1.0391-H/52.91+H^2/7975|"
    "0.6086-L/11.95-L^2/304.4|.298",
    ("push initial", "male"): "70.3|1.2737-H/1.335+H^2/2.576||1.0790-L/9.392|0.6281-L/13.07-L^2/379.5|.231",
    ("push sustained", "male"): "65.3|2.2940-H/0.3345+H^2/0.6887||1.1035-L/7.170|0.4896-L/10.20-L^2/403.9|.267",
    ("pull initial", "male"): "69.8|1.7186-H/0.6888+H^2/2.025||1.0790-L/9.392|0.6281-L/13.07-L^2/379.5|.238",
    ("pull sustained", "male"): "61.0|2.1977-H/0.3850+H^2/0.9047||1.1035-L/7.170|0.4896-L/10.20-L^2/403.9|.257",
    ("carry", "female"): "28.6|1.1645-H/4.437||1.0101-H/207.8|0.6224-L/16.33|.231",
    ("carry", "male"): "74.9|1.5505-H/1.417||1.1172-L/6.332|0.5149-L/7.958-L^2/131.1|.278",
}


def one(indicator: Indicator, *operations: Operation, **shift: Any) -> Assessment:
    return evaluate(operations, Shift(**shift), [indicator])[0]


def evaluated(term: str, value: float) -> float:
    """A term of TERMS: H is the value, L its logarithm."""
    text = term.replace("^", "**").replace("H", f"({value})").replace("L", f"({math.log(value)})")
    return float(eval(text, {"__builtins__": {}})) if term else 1.0


@pytest.mark.parametrize(("kind", "sex"), sorted(TERMS))
def test_the_equations_are_those_of_another_transcription(kind: Kind, sex: Sex) -> None:
    load, reach, middle, way, often, variation = TERMS[kind, sex].split("|")
    assert sorted(TERMS) == sorted(EQUATIONS)
    equation = EQUATIONS[kind, sex]
    assert (equation.load_kg, equation.variation) == (float(load), float(variation))
    for hands_m, way_m, per_minute in itertools.product((0.6, 0.9, 1.2), (1.5, 4.0, 9.0), (1 / 480, 0.5, 2.0, 8.0)):
        middle_m = 0.8 * hands_m if middle else 0.0
        factors = [
            evaluated(reach, hands_m), evaluated(middle, 0.8 * hands_m), evaluated(way, way_m),
            evaluated(often, per_minute),
        ]  # fmt: skip
        expected = float(load) * math.prod(max(0.0, factor) for factor in factors)
        assert equation.median_kg(hands_m, way_m, per_minute, middle_m) == pytest.approx(expected, rel=1e-9)


def test_published_values_of_liberty_mutual() -> None:
    """From the unit tests of arthurits/ErgoCalculator: a woman's lift, a man's pull."""
    lift = EQUATIONS["lift", "female"]
    assert lift.median_kg(0.38, 0.51, 1, 1.03) == pytest.approx(15.55552892693037, rel=1e-12)
    shares = [lift.capable_percent(load, 15.55552892693037) for load in (12.827597, 10.372374, 12.0)]
    assert [round(share, 1) for share in shares] == [75.0, 90.0, 81.0]
    initial, later = EQUATIONS["pull initial", "male"], EQUATIONS["pull sustained", "male"]
    assert initial.median_kg(1.2, 20, 1) == pytest.approx(22.909828065410867, rel=1e-12)
    assert later.median_kg(1.2, 20, 1) == pytest.approx(13.771820471847821, rel=1e-12)
    assert initial.capable_percent(19.232146343698815, 22.909828065410867) == pytest.approx(75, abs=1e-3)
    assert later.capable_percent(9.2359508637212127, 13.771820471847821) == pytest.approx(90, abs=1e-3)


def test_a_simulated_lift_is_judged(reactions: tuple[Reaction, ...]) -> None:
    operation = lifting(reactions[0])
    found = one(LibertyMutual(), operation, cycle_s=60)
    start = reactions[0].motion.phase("work").start // 10
    middle = operation.posture.hand_m[start].mean(axis=0)
    away = (middle - operation.posture.ankles_m[start])[:2]
    reach_m = float(np.hypot(*away))
    equation = EQUATIONS["lift", "male"]
    median = equation.median_kg(reach_m, 1.4 - middle[2], 1, (1.4 + middle[2]) / 2)
    if reach_m < 0.25:
        assert "reach is" in str(found.reason)
    else:
        assert found.value is not None
        assert found.value.low == pytest.approx(equation.capable_percent(5.0, median))


@pytest.mark.parametrize(
    ("stated", "reason"),
    [
        ({"handling": "none"}, "no load is lifted, lowered, pushed, pulled or carried"),
        ({"end_height_m": None}, "where the load is set down is not stated (end_height_m)"),
        ({"handling": "carry"}, "how far the load is moved is not stated (moved_m)"),
        ({"handling": "push", "moved_m": 1.0}, "way is 1 m; the equations are for 2.1 to 61"),
    ],
)
def test_what_the_equations_do_not_know(reactions: tuple[Reaction, ...], stated: Any, reason: str) -> None:
    assert reason in str(one(LibertyMutual(), lifting(reactions[0], **stated), cycle_s=60).reason)
    single = Operation.of(reactions[0], Circumstances(handling="lift"))
    assert "one hand" in str(one(LibertyMutual(), single).reason)


def test_published_values_of_the_strain_index() -> None:
    """The Spanish notes NTP 1125 and 1169, by ErgoCalculator: one effort, and three with their composite."""
    effort = Effort(0.2, 5, 3, -5)
    parts = [
        intensity_multiplier(0.2), frequency_multiplier(5), duration_multiplier(3), posture_multiplier(-5),
        hours_multiplier(4),
    ]  # fmt: skip
    assert [round(part, 4) for part in parts] == [2.616, 1.35, 1.38, 1.0552, 0.7698]
    assert round(strain_index(effort, 4), 3) == 3.959
    three = [Effort(0.7, 1, 1, 0), Effort(0.4, 2.6, 1.2, 0), Effort(0.2, 5, 3, 0)]
    assert [round(strain_index(one, 4), 3) for one in three] == [2.357, 2.384, 3.752]
    for order in itertools.permutations(three):
        assert round(composite_index(order, 4), 3) == 7.501


def test_the_pieces_of_the_strain_index_join() -> None:
    for function, edge in (
        (intensity_multiplier, 0.4), (frequency_multiplier, 90), (duration_multiplier, 60), (posture_multiplier, 30),
        (posture_multiplier, 0), (hours_multiplier, 0.05),
    ):  # fmt: skip
        below, above = function(edge - 1e-9), function(edge + 1e-9)
        assert below == pytest.approx(above, rel=0.05), function.__name__


def test_the_strain_index_of_an_operation(reactions: tuple[Reaction, ...]) -> None:
    """The wrist's angle and load at work, one effort of 6 s in a cycle of 30 s; a stated grip above the load counts."""
    known = Circumstances(effort_share=0.6)
    found = one(StrainIndex(), Operation.of(reactions[0], known), cycle_s=30, hours=4)
    work = reactions[0].motion.phase("work")
    bent = -Operation.of(reactions[0], step_s=0).posture.wrist_deg[work, 0][::10]
    worst = max(bent, key=posture_multiplier)
    assert found.value is not None
    assert found.value.low == pytest.approx(strain_index(Effort(0.6, 2, 6, worst), 4))
    # 16 s of every 30 s with 60 actions a minute, each of a second
    assert [decides.key for decides in found.decides] == ["actions_per_minute"] * 3
    assert found.value.high == pytest.approx(strain_index(Effort(0.6, 32, 1, worst), 4)) == found.decides[2].value
    assert found.worst is not None
    assert found.worst.side == "right"
    counted = replace(Operation.of(reactions[0]), stated=Circumstances(effort_share=0.6, actions_per_minute=30))
    screws = one(StrainIndex(), counted, cycle_s=32, hours=4)
    assert (screws.parts["per_minute"], screws.parts["duration_s"]) == (pytest.approx(15), 2)
    unknown = one(StrainIndex(), Operation.of(reactions[0]), cycle_s=30)
    assert {decides.key for decides in unknown.decides} == {"effort_share", "hours", "actions_per_minute"}
    assert unknown.levels is not None
    assert unknown.levels[1] == Level.NOT_ACCEPTABLE


def cumulative_by_rates(tasks: list[Task]) -> float:
    """CUSI a second time: each task strains at its COSI / HM; the hardest is felt alone up to its hours, and so on.

    The integral of the strain over the rising multiplier of the hours, in the order of the indices.
    """
    edges = np.cumsum([0.0, *(task.hours for task in sorted(tasks, reverse=True))])
    multiplier = [0.0, *map(hours_multiplier, edges[1:].tolist())]
    rates = [task.composite / hours_multiplier(task.hours) for task in sorted(tasks, reverse=True)]
    return float(np.dot(rates, np.diff(multiplier)))


@pytest.mark.parametrize("hours", [(4.0, 4.0), (0.5, 7.0), (2.0, 1.0, 5.0), (8.0,)])
def test_a_second_computation_of_the_cumulative_index(hours: tuple[float, ...]) -> None:
    """No example of the paper could be read; from its abstract: from the worst task to the hardest for all hours."""
    tasks = [Task(index, each) for index, each in zip((7.501, 3.959, 11.2), hours, strict=False)]
    for order in itertools.permutations(tasks):
        found = cumulative_index(order)
        assert found == pytest.approx(cumulative_by_rates(tasks), rel=1e-12)
        hardest = max(task.composite / hours_multiplier(task.hours) for task in tasks)
        assert max(tasks).composite <= found <= hardest * hours_multiplier(sum(hours)) * (1 + 1e-12)
    # what is done in two spells is as what is done in one, with as many hours
    efforts = [Effort(0.7, 1, 1, 0), Effort(0.4, 2.6, 1.2, 0), Effort(0.2, 5, 3, 0)]
    alike = [Task(composite_index(efforts, 3), 3), Task(composite_index(efforts, 3), 3)]
    assert cumulative_index(alike) == pytest.approx(composite_index(efforts, 6), rel=1e-12)


def test_the_cumulative_index_is_that_of_the_shift(reactions: tuple[Reaction, ...]) -> None:
    """What the hands do elsewhere counts; where nothing else is stated, the composite index says it."""
    operation = Operation.of(reactions[0], Circumstances(effort_share=0.6, actions_per_minute=2))
    alone = one(StrainIndex(), operation, cycle_s=30, hours=4)
    assert alone.value is not None
    assert "no other work" in str(one(CumulativeStrainIndex(), operation, cycle_s=30, hours=4).reason)
    others = (OtherWork(strain_index=6.2, hours=3), OtherWork(strain_index=20, hours=0.5))
    assert "how long" in str(one(CumulativeStrainIndex(), operation, other_work=others).reason)
    found = one(CumulativeStrainIndex(), operation, cycle_s=30, hours=4, other_work=others)
    assert found.value is not None
    tasks = [Task(alone.value.low, 4), Task(6.2, 3), Task(20, 0.5)]
    assert found.value.low == found.value.high == pytest.approx(cumulative_by_rates(tasks), rel=1e-12)
    assert found.levels == (Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE)


def test_damage_of_duet_follows_from_its_curve() -> None:
    """Table 1 by its S-N curve: N = 10^((101.25 - S) / 14.83) cycles at S % of the strength of the tendon."""
    for rating, damage in enumerate(DAMAGE):
        stress = round(rating * 100 / 14, 1) if rating else 3.6
        cycles = round(10 ** ((101.25 - stress) / 14.83))
        assert damage == pytest.approx(1 / cycles, abs=0.6e-8), rating


# Table 3 as in nbarr1/ErgonomicTool: efforts per minute and rating of each task, hours, damage in a day.
JOBS = [
    ([(3.75, 2), (1.5, 4), (4.5, 6)], 10, 0.3283155),
    ([(10, 2), (4, 2)], 9, 0.0103572),
    ([(2.73, 2), (30, 2), (5.4545, 4), (2.7273, 2)], 10, 0.07044737),
]


@pytest.mark.parametrize(("tasks", "hours", "expected"), JOBS)
def test_published_jobs_of_duet(
    reactions: tuple[Reaction, ...], tasks: list[tuple[float, int]], hours: float, expected: float
) -> None:
    """Tasks one after another in a cycle, so often that each has its efforts per minute."""
    cycle_s = 16.0 * len(tasks)
    operations = [
        Operation.of(reactions[0], Circumstances(omni_effort=rating, actions_per_minute=per_minute * len(tasks)))
        for per_minute, rating in tasks
    ]
    found = one(Duet(), *operations, cycle_s=cycle_s, hours=hours)
    # the printed hours and efforts are rounded to five digits
    assert found.parts["dose"] == pytest.approx(expected, rel=3e-5)


def test_duet_is_of_the_worse_hand(reactions: tuple[Reaction, ...]) -> None:
    """What the left hand does as well is no dose of the right one; both hands at once are one dose each."""
    right = Operation.of(reactions[0], Circumstances(omni_effort=5), name="right")
    goal = next(iter(right.request.action.goals().values()))
    left = replace(right, name="left", request=replace(right.request, action=Action(left_hand=goal)))
    left = replace(left, stated=Circumstances(omni_effort=6))
    alone, both = one(Duet(), left, cycle_s=60, hours=8), one(Duet(), right, left, cycle_s=60, hours=8)
    assert both.value == alone.value is not None
    counted = one(
        Duet(), replace(left, stated=Circumstances(omni_effort=6, actions_per_minute=60)), cycle_s=60, hours=8
    )
    assert counted.value is not None and alone.value.high == counted.value.low == counted.value.high > alone.value.low
    assert both.worst is not None
    assert (both.worst.operation, both.worst.side) == ("left", "left")
    assert both.parts == {"dose": pytest.approx(480 * DAMAGE[6]), "dose of left": pytest.approx(480 * DAMAGE[6])}
    together = replace(left, request=replace(right.request, action=Action(right_hand=goal, left_hand=goal)))
    assert one(Duet(), together, cycle_s=60, hours=8).value == alone.value


def test_published_probabilities_of_duet(reactions: tuple[Reaction, ...]) -> None:
    """5,400 efforts a day at 2: a dose of .0074, 26.5 %; the cut point of .03: 36.2 %."""
    assert round(5400 * DAMAGE[2], 4) == 0.0074
    assert [round(100 * probability(dose), 1) for dose in (0.0074, 0.03)] == [26.5, 36.2]
    operation = Operation.of(reactions[0], Circumstances(omni_effort=2, actions_per_minute=11.25))
    found = one(Duet(), operation, hours=8)
    assert found.value is not None
    assert round(found.value.low, 1) == 26.5
    assert found.text() == "26.5 %"
    assert found.levels == (Level.ACCEPTABLE, Level.ACCEPTABLE)

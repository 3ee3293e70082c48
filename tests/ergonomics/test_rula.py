"""RULA: its tables against another transcription, worked examples, a second computation at every tick, the unknown."""

import itertools
import re
from dataclasses import replace

import numpy as np
import plain_rula
import pytest
from conftest import ROOT
from second_reading import SIDES, readings

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.ergonomics.indicators.rula import Rula, table_a, table_b, table_c
from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.result import Assessment, Level
from fatigue_planner.ergonomics.stated import Circumstances, Shift
from fatigue_planner.reactions.reaction import Reaction

NOTHING = {"actions_per_minute": 0.0, "shock": False, "shoulder_raised": False}


def one(*operations: Operation, **shift: float) -> Assessment:
    return evaluate(operations, Shift(**shift), [Rula()])[0]


def array(*points: int) -> list[np.ndarray]:
    return [np.array([point]) for point in points]


def test_the_tables_are_those_of_another_transcription() -> None:
    for points in itertools.product(range(1, 7), range(1, 4), range(1, 5), range(1, 3)):
        assert table_a(*array(*points))[0] == plain_rula.table_a(*points), points
    for points in itertools.product(range(1, 7), range(1, 7), range(1, 3)):
        assert table_b(*array(*points))[0] == plain_rula.table_b(*points), points
    for points in itertools.product(range(1, 15), range(1, 15)):
        assert table_c(*array(*points))[0] == plain_rula.table_c(*points), points


def test_the_page_lists_where_the_other_table_a_differs() -> None:
    """31 cells, all lower in the other; rows as upper arm and lower arm."""
    page = (ROOT / "docs/ergonomics.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d)\.(\d) \| ([\d ]+) \| ([\d* ]+) \|$", page, re.MULTILINE)
    lower = 0
    for upper_arm, lower_arm, here, other in rows:
        arm = int(upper_arm), int(lower_arm)
        wrists = list(itertools.product(range(1, 5), range(1, 3)))
        assert [table_a(*array(*arm, *wrist))[0] for wrist in wrists] == [int(cell) for cell in here.split()]
        for cell, differs in zip(here.split(), other.split(), strict=True):
            assert differs.startswith("**") == (int(differs.strip("*")) < int(cell)), (arm, cell, differs)
            lower += differs.startswith("**")
    assert (len(rows), lower) == (11, 31)


@pytest.mark.parametrize(
    ("arm", "body", "extra", "expected"),
    [
        # points of arm and body, points of muscle and force -> scores A, B, C, D and the grand score
        ((2, 1, 2, 1), (2, 2, 1), (0, 0), (3, 2, 3, 2, 3)),
        ((3, 2, 3, 1), (3, 3, 1), (1, 1), (4, 4, 6, 6, 7)),
        ((4, 3, 3, 2), (1, 5, 1), (1, 2), (5, 6, 8, 9, 7)),
    ],
)
def test_worked_examples(
    arm: tuple[int, ...], body: tuple[int, ...], extra: tuple[int, int], expected: tuple[int, ...]
) -> None:
    a, b = table_a(*array(*arm))[0], table_b(*array(*body))[0]
    c, d = a + sum(extra), b + sum(extra)
    assert (a, b, c, d, table_c(*array(c, d))[0]) == expected


@pytest.mark.parametrize(("c", "d", "grand"), [(4, 4, 4), (8, 7, 7), (3, 7, 6), (12, 12, 7), (1, 1, 1)])
def test_published_grand_scores(c: int, d: int, grand: int) -> None:
    assert table_c(*array(c, d))[0] == grand


def test_a_published_case_of_table_b() -> None:
    """Trunk of 20 to 60 degrees, twisted and bent sideways: 5 points; with a neck of 1 to 3, legs of 1: 6."""
    assert [table_b(*array(neck, 5, 1))[0] for neck in (1, 2, 3)] == [6, 6, 6]


@pytest.mark.parametrize(
    ("load_kg", "points"),
    [(0, (0, 0)), (1.99, (0, 0)), (2, (1, 2)), (10, (1, 2)), (10.1, (2, 3)), (60, (2, 3))],
)
def test_points_of_a_load(load_kg: float, points: tuple[int, int]) -> None:
    found = [int(Rula.force_points(np.array([load_kg]), static, np.array(False))[0]) for static in (False, True)]
    assert tuple(found) == points
    assert Rula.force_points(np.array([load_kg]), False, np.array(True))[0] == 3


@pytest.mark.parametrize("stride", [97, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("more", [set(), {"repeated", "raised"}, {"shock", "supported"}])
def test_a_second_computation_finds_the_same(reactions: tuple[Reaction, ...], stride: int, more: set[str]) -> None:
    stated = Circumstances(
        actions_per_minute=6 if "repeated" in more else 0, shock="shock" in more,
        shoulder_raised="raised" in more, arm_supported="supported" in more,
    )  # fmt: skip
    for reaction in reactions:
        operation = Operation.of(reaction, stated, step_s=0)
        found = Rula().scores(operation, stated).total
        worst = 0
        half_width_m = operation.request.worker.anthropometry().length("shoulder_half_width")
        for tick, seen in readings(reaction, stride).items():
            for i, side in enumerate(SIDES):
                load_kg = 5.0 if side == "right" else 0.0
                expected = plain_rula.rula(seen, side, half_width_m, (load_kg, 5.0), more, side == "right")
                assert found[tick, i] == expected, f"{reaction.name}, tick {tick}, {side}"
                worst = max(worst, expected)
        assert 3 <= worst <= 7


def test_what_is_not_stated_makes_a_range(reactions: tuple[Reaction, ...]) -> None:
    """Stated to be mild, the score is the low end; each unknown is named with what it would make of it."""
    operation = Operation.of(reactions[0])
    unknown = one(operation)
    assert unknown.value is not None
    assert {one.key for one in unknown.decides} <= set(NOTHING)
    mild = one(replace(operation, stated=Circumstances(**NOTHING)))
    assert (mild.value, mild.decides) == ((unknown.value.low, unknown.value.low), ())
    worst = {"actions_per_minute": 5.0, "shock": True, "shoulder_raised": True}
    for decides in unknown.decides:
        alone = one(replace(operation, stated=Circumstances(**NOTHING | {decides.key: worst[decides.key]})))
        assert alone.value == (decides.value, decides.value)
        assert decides.value > unknown.value.low
    severe = one(replace(operation, stated=Circumstances(**worst)))
    assert severe.value == (unknown.value.high, unknown.value.high)
    assert unknown.text() == "4 (7 if repeated more than 4 times a minute; 7 with shocks; 7 if all)"


@pytest.mark.parametrize("stated", [{}, {"actions_per_minute": 2.0}])
def test_a_short_cycle_is_repetition(reactions: tuple[Reaction, ...], stated: dict[str, float]) -> None:
    """Of 8 s, in a cycle of 10 s: 6 times a minute, whatever fewer actions are stated; in 20 s, 3 times."""
    mild = NOTHING | {"actions_per_minute": None}
    operation = Operation.of(reactions[0], Circumstances.model_validate(mild | stated))
    operation = replace(operation, motion=replace(operation.motion, time_step_s=0.005))
    short, longer = one(operation, cycle_s=10), one(operation, cycle_s=20)
    assert (short.value, short.decides) == ((7, 7), ())
    assert longer.value == ((4, 4) if stated else (4, 7))
    twice = replace(operation, stated=operation.stated.model_copy(update={"times_per_cycle": 2}))
    assert one(twice, cycle_s=20).value == (7, 7)


def test_a_cycle_of_several_operations(reactions: tuple[Reaction, ...]) -> None:
    """The worst operation decides; times add up, repetitions included; and a cycle has to be long enough."""
    operations = [Operation.of(reaction, Circumstances(**NOTHING)) for reaction in reactions[:2]]
    single = [one(operation) for operation in operations]
    both = one(*operations, cycle_s=60)
    values = [found.value.low for found in single if found.value]
    assert both.value is not None
    assert both.value.low == max(values)
    assert both.worst is not None
    assert both.worst.operation == operations[values.index(max(values))].name
    np.testing.assert_allclose(both.times, np.sum([found.times for found in single], axis=0))
    twice = one(Operation.of(reactions[0], Circumstances(times_per_cycle=2, **NOTHING)))
    np.testing.assert_allclose(twice.times, 2 * np.array(single[0].times))
    assert sum(twice.times or ()) == pytest.approx(32)
    with pytest.raises(DataFileError, match=r"cycle_s = 20 s is shorter than its operations, 32 s together"):
        one(*operations, cycle_s=20)


def test_a_result_is_plain_data(reactions: tuple[Reaction, ...]) -> None:
    plain = one(Operation.of(reactions[0])).plain()
    assert plain["indicator"] == "rula"
    assert plain["levels"] == ["investigate", "not acceptable"]
    assert plain["words"] == ["investigate further; change may be needed", "investigate and change immediately"]
    assert plain["parts"]["score C"] == plain["parts"]["score A"] + plain["parts"]["force of the arm"]
    assert list(plain["times"]) == ["acceptable_s", "investigate_s", "not_acceptable_s"]
    assert [Rula().level_of(score) for score in (1, 2, 3, 6, 7)] == [
        Level.ACCEPTABLE, Level.ACCEPTABLE, Level.INVESTIGATE, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE,
    ]  # fmt: skip

"""REBA and OWAS: tables against other transcriptions, published examples, a second computation at every tick."""

import itertools
from dataclasses import replace

import numpy as np
import plain_owas
import plain_reba
import pytest
from second_reading import SIDES, readings

from fatigue_planner.ergonomics.indicators import owas, reba
from fatigue_planner.ergonomics.indicators.owas import Owas
from fatigue_planner.ergonomics.indicators.reba import Reba
from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.stated import Circumstances
from fatigue_planner.reactions.reaction import Reaction

STRIDES = [97, pytest.param(1, marks=pytest.mark.slow)]


def array(*points: int) -> list[np.ndarray]:
    return [np.array([point]) for point in points]


def test_the_tables_of_reba_are_those_of_another_transcription() -> None:
    for points in itertools.product(range(1, 4), range(1, 6), range(1, 5)):
        assert reba.table_a(*array(*points))[0] == plain_reba.table_a(*points), points
    for points in itertools.product(range(1, 7), range(1, 3), range(1, 4)):
        assert reba.table_b(*array(*points))[0] == plain_reba.table_b(*points), points
    for points in itertools.product(range(1, 16), range(1, 16)):
        assert reba.table_c(*array(*points))[0] == plain_reba.table_c(*points), points


def test_the_table_of_owas_differs_from_another_in_two_cells() -> None:
    found = {}
    for code in itertools.product(range(1, 5), range(1, 4), range(1, 8), range(1, 4)):
        ours, theirs = int(owas.category(*array(*code))[0]), plain_owas.category(*code)
        if ours != theirs:
            found[code] = (theirs, ours)
    assert found == plain_owas.DIFFERENCES


def test_published_values_of_reba() -> None:
    """From the tests of hfelabs-boop/ErgoCapture, and the doctests and README of rs9000/ergonomics."""
    assert [int(reba.table_a(*array(*at))[0]) for at in ((2, 3, 2), (3, 1, 1), (3, 5, 4), (1, 2, 3))] == [5, 3, 9, 4]
    assert [int(reba.table_b(*array(*at))[0]) for at in ((3, 2, 2), (6, 2, 3), (2, 1, 2), (1, 2, 2))] == [5, 9, 2, 2]
    assert [int(reba.table_c(*array(*at))[0]) for at in ((5, 5), (6, 1), (1, 1), (12, 12), (4, 2))] == [6, 6, 1, 12, 4]
    a = int(reba.table_a(*array(2, 2, 2))[0])
    assert (a, int(reba.table_c(*array(a, 2))[0])) == (4, 4)


@pytest.mark.parametrize(
    ("code", "expected"),
    [((1, 1, 2, 1), 1), ((2, 1, 4, 1), 3), ((1, 2, 2, 1), 1), ((4, 3, 4, 3), 4), ((3, 1, 5, 1), 4)],
)
def test_published_categories_of_owas(code: tuple[int, ...], expected: int) -> None:
    assert owas.category(*array(*code))[0] == expected


@pytest.mark.parametrize("stride", STRIDES)
@pytest.mark.parametrize(
    ("more", "coupling"), [(set(), "good"), ({"repeated", "raised"}, "fair"), ({"shock", "supported", "rapid"}, "poor")]
)
def test_a_second_computation_of_reba_finds_the_same(
    reactions: tuple[Reaction, ...], stride: int, more: set[str], coupling: str
) -> None:
    stated = Circumstances.model_validate({
        "actions_per_minute": 6 if "repeated" in more else 0, "shock": "shock" in more, "coupling": coupling,
        "shoulder_raised": "raised" in more, "arm_supported": "supported" in more, "rapid_changes": "rapid" in more,
    })  # fmt: skip
    for reaction in reactions:
        found = Reba().scores(Operation.of(reaction, stated, step_s=0), stated).total
        for tick, seen in readings(reaction, stride).items():
            for i, side in enumerate(SIDES):
                held_kg = 5.0 if side == "right" else 0.0
                points = reba.COUPLING[coupling]
                expected = plain_reba.reba(seen, side, (held_kg, 5.0), points, more, side == "right")
                assert found[tick, i] == expected, f"{reaction.name}, tick {tick}, {side}"


@pytest.mark.parametrize("stride", STRIDES)
@pytest.mark.parametrize("load_kg", [5.0, 10.0, 20.5])
def test_a_second_computation_of_owas_finds_the_same(
    reactions: tuple[Reaction, ...], stride: int, load_kg: float
) -> None:
    stated = Circumstances(load_kg=load_kg)
    for reaction in reactions:
        found = Owas().scores(Operation.of(reaction, stated, step_s=0), stated).total
        for tick, seen in readings(reaction, stride).items():
            assert found[tick].tolist() == [plain_owas.owas(seen, load_kg)] * 2, f"{reaction.name}, tick {tick}"


def test_coupling_matters_only_with_something_in_the_hand(reactions: tuple[Reaction, ...]) -> None:
    loaded = Operation.of(reactions[0])
    free = replace(loaded, stated=Circumstances(load_kg=0))
    keys = [{option.key for option in Reba().options(operation)} for operation in (loaded, free)]
    assert keys[0] - keys[1] == {"coupling"}


def test_the_worst_is_told_with_place_time_and_part(reactions: tuple[Reaction, ...]) -> None:
    """low/back: the trunk; the time is the middle of the longest run of the worst score, not a passing instant."""
    operation = Operation.of(next(reaction for reaction in reactions if str(reaction.name).endswith("low/back")))
    (found,) = evaluate([operation], indicators=[Reba()])
    assert found.worst is not None
    assert found.value is not None
    assert (found.worst.operation, found.worst.part) == ("average_man/low/back", "trunk")
    scores = Reba().scores(operation, Reba().mildest(operation)).total[:, SIDES.index(found.worst.side)]
    instant = round(found.worst.time_s / operation.posture.step_s)
    assert scores[instant] == found.value.low == scores.max()
    assert (scores[instant - 3 : instant + 4] == found.value.low).all()

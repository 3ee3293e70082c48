"""Load doses: against sums written out, reaction by reaction."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from small_problems import belief_in, choice_probabilities, small_model

from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.fatigue.model import Rest
from fatigue_planner.live.doses import LivedCycle, doses, reaction_chances
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.timing import Timing

SURE = np.array([0.0, 1.0])


def timed(expertise: float) -> FatiguePomdp:
    return replace(small_model(expertise), timing=Timing(16.0, Rest(np.zeros(3), np.zeros(3), np.full(3, 0.04))))


def test_sums_of_what_was_seen() -> None:
    """By the hour in which a cycle ended; half a cycle is half the dose, a cycle of twice the time is one and rest."""
    model = timed(0)
    load_s = [[profile.load_s for profile in row] for row in model.profiles]
    found = doses(
        model,
        [
            LivedCycle(16.0, 0, SURE),
            LivedCycle(3599.9, 1, SURE, 8.0),
            LivedCycle(7200.0, 1, SURE, 32.0),
            LivedCycle(7200.0, 0, SURE, 0.0),
        ],
    )
    assert found.entries == ENTRIES[:3]
    np.testing.assert_allclose(found.mean_s[0], load_s[0][1] + 0.5 * load_s[1][1])
    np.testing.assert_allclose(found.mean_s[1:], [np.zeros(3), load_s[1][1]])
    assert (found.deviation_s == 0).all()
    assert doses(model, []).mean_s.shape == (0, 3)


def test_what_was_not_seen_widens_them() -> None:
    """Mean and deviation over all sequences of reactions, enumerated."""
    model = timed(0)
    cycles = [
        LivedCycle(16.0 * (number + 1), number % 2, np.array(chances), 12.0 if number == 1 else None)
        for number, chances in enumerate([[0.5, 0.5], [0.9, 0.1], [0.2, 0.8]])
    ]
    found = doses(model, cycles)
    weights, sums = [], []
    for reactions in product(range(2), repeat=3):
        weights.append(np.prod([cycle.chances[u] for cycle, u in zip(cycles, reactions, strict=True)]))
        sums.append(
            sum(
                (0.75 if cycle.duration_s else 1.0) * model.profiles[cycle.action][u].load_s
                for cycle, u in zip(cycles, reactions, strict=True)
            )
        )
    mean = np.average(sums, axis=0, weights=weights)
    np.testing.assert_allclose(found.mean_s, [mean])
    np.testing.assert_allclose(found.deviation_s**2, [np.average((sums - mean) ** 2, axis=0, weights=weights)])


@pytest.mark.parametrize("expertise", [0.0, 5.0])
def test_chances_are_those_of_bayes(expertise: float) -> None:
    model = timed(expertise)
    levels, weights = np.array([[0.1, 0.6, 0.2], [0.9, 0.1, 0.3]]), np.array([0.3, 0.7])
    likelihood = np.array([0.9, 0.2])
    expected = np.zeros(2)
    for fatigue, weight in zip(levels, weights, strict=True):
        costs = np.array([np.mean(profile.cycle_map().apply(fatigue) ** 2) for profile in model.profiles[1]])
        expected += weight * choice_probabilities(costs, expertise) * likelihood
    before = belief_in(model, levels, weights)
    np.testing.assert_allclose(reaction_chances(before, 1, likelihood), expected / expected.sum(), rtol=1e-12)
    assert likelihood.tolist() == [0.9, 0.2]


def test_what_cannot_have_been_seen_decides_alone() -> None:
    model = timed(np.inf)
    costs = [np.mean(profile.cycle_map().apply(np.zeros(3)) ** 2) for profile in model.profiles[0]]
    unlikely = np.eye(2)[int(np.argmax(costs))]
    assert reaction_chances(belief_in(model, np.zeros((1, 3)), [1.0]), 0, unlikely).tolist() == unlikely.tolist()

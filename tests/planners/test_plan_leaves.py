"""Lookahead with one cyclic plan for the whole belief, against enumeration; novices' moments against their states."""

import math
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from plain_python import interpreted
from small_problems import NOISY, STARTS, belief_in, lookahead, relaxed, small_model, two_starts, two_workers

from fatigue_planner.fatigue.laws.ma import DoseProfile
from fatigue_planner.planners import lookahead as lookahead_module
from fatigue_planner.planners import plan_leaves
from fatigue_planner.planners.plan_leaves import in_reach, plans_in_reach
from fatigue_planner.planners.pomcp.kernels import lookahead_kernel
from fatigue_planner.pomdp.beliefs import moments
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.beliefs.moments import belief_in_moments
from fatigue_planner.pomdp.cyclic_plans import best_plan_value, fill_values, in_turns, plan_values
from fatigue_planner.pomdp.cyclic_plans import cyclic_plans as all_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers, build_pomdp, one_worker

Weighted = list[tuple[np.ndarray, float]]


def plan_worths(model: FatiguePomdp, belief: Weighted) -> np.ndarray:
    """The weighted value of every plan (P,) by its formula."""
    square, linear, constant = model.bound_arrays
    total = np.zeros(constant.shape[1])
    for state, weight in belief:
        f, m = state[:-1], int(state[-1])
        total += weight * (constant[m] + square[m] @ f**2 + linear[m] @ f)
    return total


def value(model: FatiguePomdp, belief: Weighted, depth: int) -> float:
    """The best return from weighted states, then the best plan for all of them."""
    if depth == 0:
        return float(plan_worths(model, belief).max())
    return max(action_value(model, belief, action, depth) for action in range(len(model.actions)))


def action_value(model: FatiguePomdp, belief: Weighted, action: int, depth: int) -> float:
    total, following = 0.0, [[] for _ in model.observations]
    for state, weight in belief:
        for outcome, chance in enumerate(model.probabilities(state, action)):
            moved, reward = model.transition(state, action, outcome)
            total += weight * chance * reward
            for o, seen in enumerate(model.observation_probabilities(moved, action, outcome)):
                following[o].append((moved, weight * chance * seen))
    return total + model.discount * sum(value(model, after, depth - 1) for after in following)


def by_enumeration(belief: Belief, depth: int) -> np.ndarray:
    weighted = list(zip(belief.states, belief.weights, strict=True))
    actions = range(len(belief.model.actions))
    return np.array([action_value(belief.model, weighted, action, depth) for action in actions])


def three_workers(expertise: float) -> ExactBelief:
    """Several workers with the same expertise, the first in two states."""
    workers = Workers(np.array([1.0, 2.0, 0.7]), np.array([1.0, 0.5, 1.3]), np.full(3, expertise))
    model = small_model(0.0).for_workers(workers)
    states = np.array([model.state(STARTS[i], worker) for i, worker in ((0, 0), (1, 1), (0, 2), (1, 0))])
    return ExactBelief(model, states, np.array([0.2, 0.3, 0.1, 0.4]))


def poses() -> FatiguePomdp:
    """A novice's task of six actions, each of which tires one of six entries and rests the others."""
    rng = np.random.default_rng(11)
    rates, zeros = (np.full(6, 0.01667), np.full(6, 0.04)), np.zeros((1, 6))
    profiles = {
        (a, u): DoseProfile(
            np.eye(6)[i : i + 1] * rng.uniform(15, 30), zeros, zeros, rng.uniform(8, 15) * (1 - np.eye(6)[i]), *rates
        )
        for (i, a), u in product(enumerate("abcdef"), "xy")
    }
    return build_pomdp("abcdef", "xy", profiles, np.zeros((1, 6)), one_worker(0.0), 0.95)


@pytest.fixture(autouse=True)
def every_state_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """However few states there are, their moments take their place."""
    monkeypatch.setattr(moments, "MIN_STATES", 2)


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every lookahead runs as plain Python."""
    monkeypatch.setattr(lookahead_module, "lookahead_kernel", lambda *which: interpreted(lookahead_kernel(*which)))


BELIEFS = {
    "novice": two_starts(small_model(0.0)),
    "some expertise": two_starts(small_model(25.0)),
    "expert": two_starts(small_model(math.inf)),
    "workers": three_workers(25.0),
    "novices": three_workers(0.0),
    "any": two_workers(),
    "poses": belief_in(poses(), np.array([[0.4, 0.1, 0.3, 0.0, 0.6, 0.2], [0.1, 0.5, 0.2, 0.7, 0.0, 0.3]]), [0.4, 0.6]),
}


@pytest.mark.parametrize("name", BELIEFS)
def test_lookahead_is_the_best_return_and_then_the_best_plan_for_all(name: str) -> None:
    for depth in (1, 2) if name == "poses" else (1, 2, 3):
        found = lookahead(BELIEFS[name], depth, leaf_value="bound")
        assert found == pytest.approx(by_enumeration(BELIEFS[name], depth), rel=1e-12)


@pytest.mark.usefixtures("plain")
def test_a_doubtful_recognition_leaves_doubts_to_the_plan() -> None:
    novice = two_starts(small_model(0.0, NOISY))
    for belief, depth in ((two_workers(NOISY), 1), (two_workers(NOISY), 2), (novice, 2)):
        found = lookahead(belief, depth, leaf_value="bound")
        assert found == pytest.approx(by_enumeration(belief, depth), rel=1e-12)


def test_one_cycle_at_a_time_gives_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    belief = BELIEFS["workers"]
    two = lookahead(belief, 3, leaf_value="bound")
    monkeypatch.setattr(plan_leaves, "MAX_SUMS", 0)
    assert lookahead(belief, 3, leaf_value="bound") == pytest.approx(two, rel=1e-13)


@pytest.mark.parametrize("name", ["workers", "novices"])
def test_compiled_and_plain_python_agree_in_every_bit(name: str, request: pytest.FixtureRequest) -> None:
    compiled = lookahead(BELIEFS[name], 2, leaf_value="bound")
    request.getfixturevalue("plain")
    assert np.array_equal(lookahead(BELIEFS[name], 2, leaf_value="bound"), compiled)


def test_values_of_plans_agree_in_every_bit_with_plain_python() -> None:
    model = three_workers(0.0).model
    assert isinstance(model, FatiguePomdp)
    maps = model.mean_maps(np.arange(3))
    plans, lengths, rows = in_turns([plan for plan in all_plans(2) if len(plan) <= 4])
    fast, slow = (plan_values(maps, 0.95, 3) for _ in range(2))
    for fill, values in ((fill_values, fast), (interpreted(fill_values), slow)):
        for table in values:
            table[...] = np.nan
        fill(maps, 0.95, maps.weight / 3, plans, lengths, rows, values)
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(fast, slow, strict=True))
    state = model.state(STARTS[0], 2)
    values = plan_values(maps, 0.95, 3)
    assert interpreted(best_plan_value)(values, state) == best_plan_value(values, state)


@pytest.mark.parametrize("leaf_value", ["none", "bound"])
def test_novices_moments_are_worth_what_their_states_are(monkeypatch: pytest.MonkeyPatch, leaf_value: str) -> None:
    """To 1e-12 of the values: sums in another order."""
    rng = np.random.default_rng(7)
    known = belief_in(small_model(0.0), rng.uniform(0, 1, (40, 3)), rng.dirichlet(np.ones(40)))
    for belief, workers in ((known, 1), (BELIEFS["novices"], 3), (BELIEFS["poses"], 1)):
        assert len(belief_in_moments(belief).weights) == workers < len(belief.weights)
        short = [lookahead(belief, depth, leaf_value=leaf_value) for depth in (1, 2, 3)]
        with monkeypatch.context() as patch:
            patch.setattr(lookahead_module, "belief_in_moments", lambda belief: belief)
            whole = [lookahead(belief, depth, leaf_value=leaf_value) for depth in (1, 2, 3)]
        assert np.allclose(short, whole, rtol=1e-12, atol=0)


def test_only_novices_with_a_quadratic_cost_are_known_by_moments() -> None:
    for name in ("some expertise", "expert", "workers", "any"):
        assert belief_in_moments(BELIEFS[name]) is BELIEFS[name]
    alone = relaxed(small_model(0.0))
    assert belief_in_moments(alone) is alone


def test_a_plan_for_all_is_worth_no_more_than_one_for_each_state() -> None:
    """Two workers to whom other plans suit: the mean of what suits each is what no robot can have."""
    belief = BELIEFS["workers"]
    plans = belief.model.bound_arrays
    each = sum(w * best_plan_value(plans, s) for s, w in zip(belief.states, belief.weights, strict=True))
    weighted = list(zip(belief.states, belief.weights, strict=True))
    assert plan_worths(belief.model, weighted).max() < each - 1e-6
    alone = belief.states[0], 1.0
    assert plan_worths(belief.model, [alone]).max() == pytest.approx(
        best_plan_value(plans, belief.states[0]), rel=1e-13
    )


def test_a_deeper_lookahead_is_worth_no_less_whatever_is_believed() -> None:
    for name in ("novice", "novices"):
        values = [lookahead(BELIEFS[name], depth, leaf_value="bound").max() for depth in range(1, 5)]
        assert all(later >= earlier - 1e-15 for earlier, later in pairwise(values))


def test_plans_out_of_reach_change_no_value(monkeypatch: pytest.MonkeyPatch) -> None:
    belief = BELIEFS["poses"]
    whole: Any = belief.model.bound_arrays
    values = lookahead(belief, 2, leaf_value="bound")
    monkeypatch.setattr(plan_leaves, "MANY_HISTORIES", 0)
    few = plans_in_reach(belief, whole, 2)
    assert 1 < few.constant.size < whole.constant.size
    assert lookahead(belief, 2, leaf_value="bound") == pytest.approx(values, rel=1e-13)


def test_what_is_in_reach_holds_every_state() -> None:
    """Also that of the moments; and the extremes are reached, so that there is no room to spare."""
    belief = BELIEFS["poses"]
    for of in (belief, belief_in_moments(belief)):
        low, high = in_reach(of, 2)
        states = list(of.states)
        for _ in range(2):
            states = [of.model.transition(s, a, u)[0] for s in states for a in range(6) for u in range(2)]
        found = np.array(states)[:, :-1]
        assert (found.min(axis=0) == low).all() and (found.max(axis=0) == high).all()

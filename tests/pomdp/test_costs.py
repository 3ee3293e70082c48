"""Costs by name: kernels against numpy, plans and bounds with weights; where only a quadratic will do."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from small_problems import STARTS, belief_in, choice_probabilities, relaxed, small_profiles

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.planners.bounds.cost_bound import bound_of
from fatigue_planner.planners.lookahead import LookaheadPolicy, LookaheadSettings, reference_for
from fatigue_planner.planners.pomcp.policy import PomcpPolicy, PomcpSettings
from fatigue_planner.pomdp.beliefs.registry import ExactSettings
from fatigue_planner.pomdp.cost import FatigueCost, mean_square
from fatigue_planner.pomdp.cyclic_plans import best_plan_value
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, build_pomdp, one_worker
from fatigue_planner.pomdp.scenario import Scenario

WEIGHTS = np.array([0.0, 2.5, 0.7])
POSTURE = {("a", "x"): 0.0, ("a", "y"): 0.02, ("b", "x"): 0.05, ("b", "y"): 0.001}
COSTS = {
    "weighted": FatigueCost("mean_square", WEIGHTS),
    "worst": FatigueCost("worst_joint", np.ones(3)),
    "weighted worst": FatigueCost("worst_joint", WEIGHTS),
}
NAMES = list(product("ab", "xy"))


def model_with(cost: FatigueCost, expertise: float, posture: bool = True) -> FatiguePomdp:
    profiles = {
        name: replace(profile, posture_cost=POSTURE[name] if posture else 0.0)
        for name, profile in small_profiles().items()
    }
    return build_pomdp("ab", "xy", profiles, np.zeros((1, 3)), one_worker(expertise), 0.95, cost=cost)


def by_hand(cost: FatigueCost, fatigue: np.ndarray, action: str) -> np.ndarray:
    """The cost after each reaction to an action."""
    costs = []
    for u in "xy":
        f = small_profiles()[action, u].cycle_map().apply(fatigue)
        own = max(cost.weights * f) if cost.kind == "worst_joint" else sum(cost.weights * f * f) / 3
        costs.append(own + POSTURE[action, u])
    return np.array(costs)


@pytest.mark.parametrize("expertise", [0.0, 40.0, np.inf])
@pytest.mark.parametrize("name", list(COSTS))
def test_rewards_and_choices_are_those_of_the_cost(name: str, expertise: float) -> None:
    cost, rng = COSTS[name], np.random.default_rng(0)
    model = model_with(cost, expertise)
    for fatigue in STARTS:
        state = model.state(fatigue)
        for a, action in enumerate("ab"):
            costs = by_hand(cost, fatigue, action)
            chances = choice_probabilities(costs, expertise)
            for u in range(2):
                moved, reward = model.transition(state, a, u)
                assert reward == pytest.approx(-costs[u], rel=1e-12)
                np.testing.assert_allclose(moved[:3], small_profiles()[action, "xy"[u]].cycle_map().apply(fatigue))
            np.testing.assert_allclose(model.probabilities(state, a), chances, atol=1e-12)
            drawn = [model.sample_step(state, a, rng)[1:] for _ in range(200)]
            assert all(chances[u] > 0 and reward == pytest.approx(-costs[u], rel=1e-12) for u, reward in drawn)
            assert np.mean([u for u, _ in drawn]) == pytest.approx(chances[1], abs=0.15)
        costs_of = [by_hand(cost, fatigue, action) for action in "ab"]
        expected = [-choice_probabilities(costs, expertise) @ costs for costs in costs_of]
        found = belief_in(model, fatigue[None], [1.0]).expected_rewards()
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_without_weights_and_posture_the_cost_is_the_papers() -> None:
    """The same numbers to the last bit by the paper's own kernel and by the general one."""
    plain, general = model_with(mean_square(3), 40.0, posture=False), model_with(mean_square(3), 40.0, posture=False)
    assert plain.arrays.cost.plain and not model_with(COSTS["weighted"], 0.0, posture=False).arrays.cost.plain
    assert not model_with(mean_square(3), 0.0).arrays.cost.plain
    general = replace(general, arrays=general.arrays._replace(cost=general.arrays.cost._replace(plain=False)))
    for fatigue, action, preference in product(STARTS, range(2), range(2)):
        rewards = [model.transition(model.state(fatigue), action, preference)[1] for model in (plain, general)]
        assert rewards[0] == pytest.approx(rewards[1], rel=1e-15)


def best_return(model: FatiguePomdp, state: np.ndarray, cycles: int) -> float:
    """The best expected return, over every history."""
    if cycles == 0:
        return 0.0
    values = []
    for a in range(2):
        steps = [model.transition(state, a, u) for u in range(2)]
        after = [reward + model.discount * best_return(model, moved, cycles - 1) for moved, reward in steps]
        values.append(model.probabilities(state, a) @ after)
    return float(max(values))


@pytest.mark.parametrize("expertise", [0.0, 40.0])
@pytest.mark.parametrize("name", list(COSTS))
def test_planners_work_with_every_cost(name: str, expertise: float) -> None:
    """The lookahead and the search with exact backups find the best return of four cycles."""
    model = model_with(COSTS[name], expertise)
    best = best_return(model, model.state(np.zeros(3)), 4)
    rng = np.random.default_rng(0)
    looked = LookaheadPolicy(LookaheadSettings(kind="lookahead", depth=4)).act(relaxed(model), rng)
    assert looked.values.max() == pytest.approx(best, rel=1e-12)
    searched = PomcpPolicy(PomcpSettings(kind="pomcp", backup="max", exploration_constant=0.1, descents=300))
    assert np.isfinite(searched.act(relaxed(model), rng).values).all()


def test_a_plan_is_worth_its_next_cycle_and_what_follows() -> None:
    """Bellman's equation where there is one action, with weights and posture; with two actions the best is no worse."""
    both = model_with(COSTS["weighted"], 0.0)
    for a in range(2):
        profiles = {("a", u): both.profiles[a][i] for i, u in enumerate("xy")}
        only = build_pomdp("a", "xy", profiles, np.zeros((1, 3)), one_worker(0.0), 0.95, cost=both.cost)
        for fatigue in STARTS:
            state = only.state(fatigue)
            following = [only.transition(state, 0, u) for u in range(2)]
            ahead = np.mean([reward + 0.95 * best_plan_value(only.bound_arrays, moved) for moved, reward in following])
            worth = best_plan_value(only.bound_arrays, state)
            assert worth == pytest.approx(ahead, rel=1e-12)
            assert best_plan_value(both.bound_arrays, both.state(fatigue)) >= worth - 1e-12


@pytest.mark.parametrize("expertise", [0.0, 40.0, np.inf])
@pytest.mark.parametrize("posture", [False, True])
def test_the_bound_holds_for_weights_and_posture(expertise: float, posture: bool) -> None:
    """Exact for a few cycles; for more it stays below the best return of an exact lookahead."""
    model = model_with(COSTS["weighted"], expertise, posture)
    for start in STARTS:
        states = model.state(start)[None]
        scenario = Scenario(model, states, np.ones(1), None, ExactSettings(kind="exact"))
        found = bound_of(scenario, 4)
        assert found.exact and found.cost == pytest.approx(-best_return(model, states[0], 4), rel=1e-9)
        longer = bound_of(replace(scenario), 7)
        assert longer.cost <= -best_return(model, states[0], 7) + 1e-12


def test_what_needs_a_quadratic_refuses_another_cost() -> None:
    model = model_with(COSTS["worst"], 0.0)
    scenario = Scenario(model, STARTS[:1], np.ones(1), None, ExactSettings(kind="exact"))
    with pytest.raises(ExperimentError, match=r"the bound of the cost: needs a cost that is quadratic .* worst_joint"):
        bound_of(scenario, 5)
    with pytest.raises(ExperimentError, match="leaf value bound: needs a cost that is quadratic"):
        _ = model.bound_arrays
    assert reference_for(relaxed(model)).leaf_value == "none"
    assert reference_for(relaxed(model_with(COSTS["weighted"], 0.0))).leaf_value == "bound"

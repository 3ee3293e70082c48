"""Schedules: cost against step-by-step sums, search against brute force, and the policies that follow them."""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from small_problems import (
    NOISY,
    STARTS,
    belief_in,
    relaxed,
    small_model,
    small_profiles,
    two_starts,
    two_workers,
    with_discount,
)

from fatigue_planner.core.errors import ProblemError, SelectionError
from fatigue_planner.fatigue.laws.ma import DoseProfile
from fatigue_planner.planners.policy import Policy
from fatigue_planner.planners.registry import policy
from fatigue_planner.planners.robust_periodic import USUAL_WORKERS, varied
from fatigue_planner.planners.schedules.cost import SAMPLES, ClosedForm, MeanCost, Simulated, schedule_cost
from fatigue_planner.planners.schedules.policy import best_schedule_for
from fatigue_planner.planners.schedules.search import MAX_LISTED, best_schedule
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.cost import FatigueCost, mean_square
from fatigue_planner.pomdp.cyclic_plans import best_plan_value, most_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers, build_pomdp, one_worker

Plan = tuple[int, ...]


def random_task(n_actions: int, expertise: float, seed: int, discount: float = 0.9) -> ExactBelief:
    """A rested worker of six entries; every reaction loads three of them."""
    rng = np.random.default_rng(seed)
    rates, zeros = (np.full(6, 0.01667), np.full(6, 0.04)), np.zeros((1, 6))
    names = [f"a{i}" for i in range(n_actions)]
    loads = {name: rng.permutation(rng.uniform(3, 20, 6) * (np.arange(6) < 3)) for name in product(names, "xy")}
    profiles = {
        name: DoseProfile(load[None], zeros, zeros, np.where(load > 0, 8.0, 16.0), *rates)
        for name, load in loads.items()
    }
    return relaxed(build_pomdp(names, "xy", profiles, np.zeros((1, 6)), one_worker(expertise), discount))


def expected_cost(belief: Belief, plan: Plan, cycles: int) -> float:
    """The sum over all histories of so many cycles, one after the other."""
    model = belief.model

    def from_state(state: np.ndarray, cycle: int) -> float:
        if cycle == cycles:
            return 0.0
        total, action = 0.0, plan[cycle % len(plan)]
        for outcome, chance in enumerate(model.probabilities(state, action)):
            if chance > 0:
                after, reward = model.transition(state, action, outcome)
                total += chance * (model.discount * from_state(after, cycle + 1) - reward)
        return total

    return float(sum(w * from_state(s, 0) for s, w in zip(belief.states, belief.weights, strict=True)))


def costs(belief: Belief, plans: list[Plan]) -> np.ndarray:
    return schedule_cost(belief).costs(np.array(plans, dtype=np.intp))


def brute_force(cost: Callable[[Plan], float], n_actions: int, longest: int) -> float:
    return min(cost(plan) for n in range(1, longest + 1) for plan in product(range(n_actions), repeat=n))


def actions_of(made: Policy, belief: Belief, cycles: int) -> list[str]:
    """What a policy does where the first reaction is always observed."""
    rng, taken = np.random.default_rng(0), []
    for _ in range(cycles):
        action = made.act(belief, rng).action
        made.observe(action, 0)
        belief = belief.update(action, 0, rng)
        taken.append(belief.model.actions[action])
    return taken


# --- costs ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("plan", [(0,), (1, 0), (0, 1, 1)])
def test_the_cost_for_a_novice_is_the_sum_over_all_histories(plan: Plan) -> None:
    belief = with_discount(two_starts(small_model(0.0)), 0.2)
    assert costs(belief, [plan])[0] == pytest.approx(expected_cost(belief, plan, 12), rel=1e-7)


@pytest.mark.parametrize("plan", [(0,), (1, 0), (0, 1, 1)])
def test_the_cost_for_an_expert_is_that_of_his_own_choices(plan: Plan) -> None:
    belief = two_starts(small_model(math.inf))
    assert costs(belief, [plan])[0] == pytest.approx(expected_cost(belief, plan, 300), rel=1e-6)


def test_the_cost_for_others_is_a_mean_of_their_own_choices() -> None:
    belief = with_discount(two_starts(small_model(25.0)), 0.5)
    exact = expected_cost(belief, (0, 1), 14)
    novice = expected_cost(with_discount(two_starts(small_model(0.0)), 0.5), (0, 1), 14)
    assert_within_chance(belief, exact)
    assert abs(novice - exact) > 1e-4 * exact  # the choices do matter


def assert_within_chance(belief: Belief, exact: float) -> None:
    """The cost of (0, 1) is within four standard errors, by the spread of the returns of single histories."""
    rng, model, returns = np.random.default_rng(5), belief.model, []
    for _ in range(400):
        state, cost = belief.states[rng.choice(2, p=belief.weights)], 0.0
        for cycle in range(14):
            state, _, reward = model.sample_step(state, cycle % 2, rng)
            cost -= model.discount**cycle * reward
        returns.append(cost)
    assert abs(costs(belief, [(0, 1)])[0] - exact) < 4 * np.std(returns) / math.sqrt(SAMPLES)
    assert abs(np.mean(returns) - exact) < 4 * np.std(returns) / math.sqrt(400)


def with_cost(cost: FatigueCost, expertise: float = 0.0, posture: float = 0.1) -> FatiguePomdp:
    """The made-up task with another cost, in which both reactions to `a` have a posture that costs something."""
    profiles = {
        (action, reaction): replace(profile, posture_cost=posture * (action == "a") * (1 + (reaction == "y")))
        for (action, reaction), profile in small_profiles().items()
    }
    return build_pomdp("ab", "xy", profiles, np.zeros((1, 3)), one_worker(expertise), 0.2, cost=cost)


WEIGHTED = FatigueCost("mean_square", np.array([0.0, 2.5, 0.7]))
WORST = FatigueCost("worst_joint", np.ones(3))


@pytest.mark.parametrize("number", [[0, 0], [1, 1], [1, 0]])
@pytest.mark.parametrize("plan", [(0,), (1, 0), (0, 1, 1)])
def test_the_closed_form_knows_weights_postures_and_workers(plan: Plan, number: list[int]) -> None:
    """Against all histories, for beliefs in the first of two workers, in the second, and in both."""
    workers = Workers(np.array([1.0, 2.0]), np.array([1.0, 0.5]), np.zeros(2))
    model = with_cost(WEIGHTED).for_workers(workers)
    states = np.array([model.state(fatigue, worker) for fatigue, worker in zip(STARTS, number, strict=True)])
    belief = ExactBelief(model, states, np.array([0.3, 0.7]))
    assert isinstance(schedule_cost(belief), ClosedForm)
    assert costs(belief, [plan])[0] == pytest.approx(expected_cost(belief, plan, 12), rel=1e-7)
    plain = ExactBelief(with_cost(mean_square(3), posture=0.0).for_workers(workers), states, np.array([0.3, 0.7]))
    assert costs(plain, [plan])[0] != pytest.approx(expected_cost(belief, plan, 12), rel=1e-3)


def test_a_cost_that_is_no_quadratic_is_simulated() -> None:
    """The most tired joint of an expert exactly, of a novice within chance."""
    expert = two_starts(with_cost(WORST, math.inf))
    assert costs(expert, [(0, 1)])[0] == pytest.approx(expected_cost(expert, (0, 1), 300), rel=1e-6)
    novice = two_starts(with_cost(WORST))
    assert isinstance(schedule_cost(novice), Simulated)
    assert_within_chance(novice, expected_cost(novice, (0, 1), 12))


def test_hidden_workers_and_noisy_observations_change_nothing_about_the_mean() -> None:
    """The cost of a belief is the weighted mean of those of its states; recognition does not matter."""
    workers = two_workers()
    mixed = costs(workers, [(0, 1, 1)])[0]
    assert mixed == pytest.approx(costs(two_workers(NOISY), [(0, 1, 1)])[0])
    starts = two_starts(small_model(0.0))
    single = [costs(belief_in(small_model(0.0), STARTS[i : i + 1], [1.0]), [(0, 1)])[0] for i in (0, 1)]
    assert costs(starts, [(0, 1)])[0] == pytest.approx(0.3 * single[0] + 0.7 * single[1])


def test_large_beliefs_are_thinned_to_about_the_same_cost() -> None:
    rng = np.random.default_rng(4)
    fatigue = rng.uniform(0, 0.5, (500, 3))
    belief = belief_in(small_model(0.0), fatigue, np.full(500, 1 / 500))
    exact = np.mean([costs(belief_in(small_model(0.0), row[None], [1.0]), [(0, 1)])[0] for row in fatigue])
    assert costs(belief, [(0, 1)])[0] == pytest.approx(exact, rel=0.05)


def test_without_a_discount_schedules_have_no_cost() -> None:
    with pytest.raises(ProblemError, match="discount below 1"):
        schedule_cost(with_discount(relaxed(small_model(0.0)), 1.0))


# --- the search -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("expertise", [0.0, math.inf])
def test_few_schedules_are_all_looked_at(expertise: float) -> None:
    belief = random_task(3, expertise, seed=2)
    found = best_schedule(schedule_cost(belief), 3, longest=5)
    assert found.exact
    assert found.cost == pytest.approx(brute_force(lambda plan: costs(belief, [plan])[0], 3, 5), rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_the_search_finds_the_best_of_too_many_to_list(seed: int) -> None:
    belief, actions, longest = random_task(9, 0.0, seed), 9, 4
    assert actions**longest > MAX_LISTED
    found = best_schedule(schedule_cost(belief), actions, longest)
    assert not found.exact
    every = [plan for n in range(1, longest + 1) for plan in product(range(actions), repeat=n)]
    least = min(costs(belief, [plan for plan in every if len(plan) == n]).min() for n in range(1, longest + 1))
    assert found.cost == pytest.approx(least, rel=1e-12)


@pytest.mark.parametrize("expertise", [0.0, 200.0, math.inf])
def test_nothing_is_lost_beyond_32_actions(expertise: float) -> None:
    """The best of all pairs is never better than what is found among 36 actions, of which no pairs are listed."""
    belief = random_task(36, expertise, seed=7)
    found = best_schedule(schedule_cost(belief), 36)
    pairs = [(a, b) for a, b in product(range(36), repeat=2) if a != b]
    assert found.cost <= costs(belief, pairs).min() * (1 + 1e-12)
    assert found.cost == pytest.approx(costs(belief, [found.actions])[0], rel=1e-12)
    assert len(found.actions) > 1


def test_leaf_values_know_good_schedules_of_more_than_31_actions() -> None:
    """For a rested worker no pair beats the best cyclic plan, whose value is within 1 % of the best schedule's."""
    belief = random_task(36, 0.0, seed=7)
    values = belief.model.bound_arrays
    found = -best_plan_value(values, belief.states[0])
    pairs = costs(belief, [(a, b) for a, b in product(range(36), repeat=2) if a != b])
    best = best_schedule(schedule_cost(belief), 36).cost
    assert best <= found * (1 + 1e-12) and found <= min(pairs.min(), 1.01 * best)
    assert found < costs(belief, [(a,) for a in range(36)]).min() * 0.99
    assert values.constant.shape[1] <= most_plans(36)


def test_the_shortest_of_equal_schedules_is_taken() -> None:
    """Two actions that are the same: one of them, for ever."""
    belief = random_task(1, 0.0, seed=3)
    assert best_schedule(schedule_cost(belief), 1).actions == (0,)


def test_one_schedule_for_several_workers_has_the_least_mean_cost() -> None:
    first, second = random_task(3, 0.0, seed=2), random_task(4, math.inf, seed=8)
    numbers = np.arange(3), np.array([3, 1, 2])  # the second knows the common actions by other numbers
    together = MeanCost([(schedule_cost(first), numbers[0]), (schedule_cost(second), numbers[1])])
    found = best_schedule(together, 3, longest=4)

    def mean(plan: Plan) -> float:
        own = tuple(int(numbers[1][a]) for a in plan)
        return float(costs(first, [plan])[0] + costs(second, [own])[0]) / 2

    assert found.cost == pytest.approx(brute_force(mean, 3, 4), rel=1e-12)


def test_the_same_schedule_is_searched_for_once() -> None:
    belief, same = random_task(3, 0.0, seed=2), random_task(3, 0.0, seed=2)
    assert best_schedule_for(belief, 4) is best_schedule_for(same, 4)
    assert best_schedule_for(belief, 4) is not best_schedule_for(belief, 3)
    assert best_schedule_for(random_task(3, 0.0, seed=3), 4) is not best_schedule_for(belief, 4)


def test_another_cost_has_another_schedule() -> None:
    """Postures and the kind of the cost count: nothing is remembered of the same fatigue under another cost."""
    models = [with_cost(WEIGHTED, posture=0.0), with_cost(WEIGHTED), with_cost(WORST), with_cost(mean_square(3))]
    found = [best_schedule_for(relaxed(model), 3) for model in models]
    assert len({schedule.cost for schedule in found}) == 4
    assert [schedule.actions for schedule in found[:2]] == [(0,), (1,)]  # the posture of `a` costs something


# --- the policies -----------------------------------------------------------------------------------------------


def test_fixed_is_the_most_ergonomic_action_of_one_cycle_or_the_named_one() -> None:
    belief = random_task(5, 0.0, seed=1)
    best = belief.model.actions[int(belief.expected_rewards().argmax())]
    assert actions_of(policy("fixed").build(), belief, 4) == [best] * 4
    assert actions_of(policy({"kind": "fixed", "action": "a3"}).build(), belief, 3) == ["a3"] * 3


def test_periodic_repeats_its_sequence_or_the_best_one() -> None:
    belief = random_task(4, 0.0, seed=5)
    given = policy({"kind": "periodic", "sequence": ("a1", "a1", "a0")})
    assert actions_of(given.build(), belief, 7) == ["a1", "a1", "a0", "a1", "a1", "a0", "a1"]
    best = best_schedule(schedule_cost(belief), 4).actions
    assert len(best) > 1
    assert actions_of(policy("periodic").build(), belief, 2 * len(best)) == 2 * [f"a{a}" for a in best]
    single = min(range(4), key=lambda a: costs(belief, [(a,)])[0])
    assert actions_of(policy({"kind": "periodic", "longest": 1}).build(), belief, 2) == [f"a{single}"] * 2


def test_robust_periodic_is_the_best_on_average_over_the_workers() -> None:
    belief = random_task(3, 0.0, seed=2)
    workers = {"fatigue_rate_factor": {"kind": "choice", "values": (0.5, 3.0), "probabilities": (0.25, 0.75)}}
    found = actions_of(policy({"kind": "robust_periodic", "workers": workers, "longest": 3}).build(), belief, 3)
    each = [belief.model.for_workers(one_worker(0.0)._replace(fatigue_rate_factor=np.array([f]))) for f in (0.5, 3.0)]

    def mean(plan: Plan) -> float:
        return 0.25 * costs(relaxed(each[0]), [plan])[0] + 0.75 * costs(relaxed(each[1]), [plan])[0]

    numbers = tuple(int(name[1:]) for name in found)
    assert mean(numbers) == pytest.approx(brute_force(mean, 3, 3), rel=1e-12)


def test_the_usual_workers_spread_as_measured_around_each_worker() -> None:
    belief = varied(two_workers(), USUAL_WORKERS)
    assert belief.weights.sum() == pytest.approx(1)
    workers = belief.model.workers
    for own, factor in ((1.5, workers.fatigue_rate_factor[:32]), (1.1, workers.recovery_rate_factor[32:])):
        logarithms = np.log(factor / own)
        assert abs(logarithms.mean()) < 1e-9
        assert logarithms.std() == pytest.approx(0.456, rel=0.05)
    assert set(workers.expertise) == {0.0, 25.0}


def two_loads(**others: float) -> tuple[ExactBelief, dict[str, object]]:
    """Action `left` tires the first entry only, `right` the second one, a little more; both tire fast."""
    rates, zeros = (np.full(2, 0.01), np.full(2, 0.04)), np.zeros((1, 2))
    loads = {"left": np.array([[30.0, 0.0]]), "right": np.array([[0.0, 31.0]])}
    profiles = {
        (name, "x"): DoseProfile(load, zeros, zeros, np.where(load[0] > 0, 2.0, 16.0), *rates)
        for name, load in loads.items()
    }
    model = build_pomdp(("left", "right"), ("x",), profiles, np.zeros((1, 2)), one_worker(0.0), 0.95)
    return relaxed(model), {"kind": "threshold", **others}


def test_threshold_changes_when_an_entry_reaches_the_level_and_not_before_it_recovers() -> None:
    """Against the cycle maps, followed by hand for two entries of which each action tires one."""
    belief, settings = two_loads(fatigue_threshold=0.5, recovery_threshold=0.3)
    gain, offset = (table[:, :2] for table in belief.model.arrays[:2])
    fatigue, tired, action, expected = np.zeros(2), np.zeros(2, bool), 0, []
    for _ in range(30):
        new = (fatigue >= 0.5) & ~tired
        tired = (tired & (fatigue > 0.3)) | new
        if new.any():
            after = [((gain[a] * fatigue + offset[a])[tired] ** 2).sum() for a in range(2)]
            action = int(np.argmin(after))
        expected.append(("left", "right")[action])
        fatigue = gain[action] * fatigue + offset[action]
    assert actions_of(policy(settings).build(), belief, 30) == expected
    assert expected[:2] == ["left", "left"] and {"left", "right"} == set(expected)
    assert sum(a != b for a, b in pairwise(expected)) > 3


def test_threshold_never_changes_where_nobody_gets_so_tired() -> None:
    belief, settings = two_loads(fatigue_threshold=0.99)
    assert actions_of(policy(settings).build(), belief, 20) == ["left"] * 20


def test_names_of_actions_are_checked_by_the_policy_too() -> None:
    belief = random_task(2, 0.0, seed=1)
    for settings in ({"kind": "fixed", "action": "b"}, {"kind": "periodic", "sequence": ("a0", "b")}):
        with pytest.raises(SelectionError, match="b: not among the actions a0, a1"):
            policy(settings).build().act(belief, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"kind": "threshold", "fatigue_threshold": 0.2, "recovery_threshold": 0.2}, "must be below the fatigue_thr"),
        ({"kind": "threshold"}, "fatigue_threshold"),
        ({"kind": "periodic", "sequence": ("a",), "longest": 3}, "leave it out, or the sequence"),
        ({"kind": "periodic", "sequence": ()}, "at least 1"),
        ({"kind": "periodic", "longest": 9}, "less than or equal to 8"),
    ],
)
def test_impossible_settings_are_refused(settings: dict[str, object], message: str) -> None:
    with pytest.raises(SelectionError, match=message):
        policy(settings)

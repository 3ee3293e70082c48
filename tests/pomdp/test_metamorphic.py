"""What must not change when a problem is stated differently: names in another order, other units, split states."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from small_problems import (
    NOISY,
    belief_in,
    lookahead,
    pomcp,
    random_tables,
    small_model,
    small_profiles,
    table_belief,
    table_problem,
    tiger_with_an_end,
    tree_of,
    two_starts,
    two_workers,
    with_discount,
)

from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, build_pomdp, one_worker
from fatigue_planner.pomdp.problem import Pomdp

TURNED = [2, 0, 1]


def turned(problem: Pomdp) -> Pomdp:
    """The same tables with the actions in another order."""
    move, reward, see, horizon = problem.arrays
    return table_problem(move[TURNED], reward[TURNED], see[TURNED], horizon, problem.discount)


def swapped(expertise: float, recognition: np.ndarray | None) -> FatiguePomdp:
    return build_pomdp("ba", "xy", small_profiles(), np.zeros((1, 3)), one_worker(expertise), 0.95, recognition)


@pytest.mark.parametrize("revealed", [False, True])
def test_actions_in_another_order_have_the_same_values(revealed: bool) -> None:
    """Lookahead: each action's value is computed in the same way, so it is the same to the last bit."""
    for seed in range(5):
        problem = random_tables(seed, actions=3, states=2, horizon=4, revealed=revealed)
        first, other = (lookahead(table_belief(p, [0.3, 0.7]), 3) for p in (problem, turned(problem)))
        np.testing.assert_array_equal(first[TURNED], other)
    recognition = None if revealed else NOISY
    first, other = (lookahead(two_starts(m), 3) for m in (small_model(9.0, recognition), swapped(9.0, recognition)))
    np.testing.assert_array_equal(first[::-1], other)


def test_a_full_search_does_not_depend_on_the_order_of_the_actions() -> None:
    """Where the tree holds all histories, the exact backup has the same values and takes the same action."""
    problem = random_tables(7, actions=3, states=2, horizon=2, revealed=True)
    first, other = (
        tree_of(table_belief(p, [1.0, 0.0]), pomcp(20_000, 1000.0, "exact")).value[0]
        for p in (problem, turned(problem))
    )
    np.testing.assert_allclose(first[TURNED], other, rtol=1e-12)
    assert TURNED[int(other.argmax())] == first.argmax()


@pytest.mark.parametrize("backup", ["mean", "max"])
def test_sampled_values_do_not_depend_on_the_order_of_the_actions(backup: str) -> None:
    """One step to go, so that the order of first tries does not matter: t-test of 150 searches, false alarm 1e-6."""
    first, other = (
        [tree_of(with_discount(two_starts(model), 0.0), pomcp(200, 0.1, backup), seed).value[0] for seed in seeds]
        for model, seeds in ((small_model(3.0), range(150)), (swapped(3.0, None), range(150, 300)))
    )
    assert (stats.ttest_ind(np.array(first)[:, ::-1], np.array(other)).pvalue > 1e-6).all()


def scaled(belief: ExactBelief, factor: float) -> ExactBelief:
    """The same belief where all rewards are multiplied by a factor; choices must not depend on the unit."""
    model = belief.model
    if isinstance(model, FatiguePomdp):
        assert model.arrays.even
        arrays = model.arrays._replace(cost=model.arrays.cost._replace(scale=model.arrays.cost.scale * factor))
    else:
        arrays = model.arrays._replace(reward=model.arrays.reward * factor)
    return replace(belief, model=replace(model, arrays=arrays))


FATIGUE = two_starts(small_model(0.0, NOISY))
TIGER = table_belief(tiger_with_an_end(4), [0.5, 0.5])


@pytest.mark.parametrize("factor", [2.0**-9, 2.0**6])
@pytest.mark.parametrize(
    ("belief", "c", "backup", "exploration"),
    [
        (FATIGUE, 0.01, "mean", "fixed"),
        (FATIGUE, 0.01, "max", "fixed"),
        (FATIGUE, 0.01, "exact", "fixed"),
        (FATIGUE, 0.5, "max", "scaled"),
        (TIGER, 50.0, "mean", "fixed"),
        (TIGER, 50.0, "max", "fixed"),
        (TIGER, 50.0, "exact", "fixed"),
    ],
)
def test_another_unit_of_reward_changes_no_decision(
    belief: ExactBelief, c: float, backup: str, exploration: str, factor: float
) -> None:
    """Powers of two: c scaled with them (scaled exploration: the same c), counts are equal, values scale exactly."""
    other_c = c if exploration == "scaled" else c * factor
    first = tree_of(belief, pomcp(500, c, backup, exploration=exploration))
    other = tree_of(scaled(belief, factor), pomcp(500, other_c, backup, exploration=exploration))
    for name in ("child", "tried", "visited"):
        np.testing.assert_array_equal(getattr(first, name), getattr(other, name))
    for name in ("value", "best"):
        np.testing.assert_array_equal(getattr(first, name) * factor, getattr(other, name))
    np.testing.assert_array_equal(lookahead(belief, 3) * factor, lookahead(scaled(belief, factor), 3))


@pytest.mark.parametrize("recognition", [None, NOISY])
def test_a_state_given_twice_is_the_same_state(recognition: np.ndarray | None) -> None:
    """Splitting states of a belief, or listing them in another order, changes no value and no later belief."""
    belief = two_workers(recognition)
    order = [3, 0, 2, 1, 0]
    weights = belief.weights[order] * [1, 0.25, 1, 1, 0.75]
    split = replace(belief, states=belief.states[order], weights=weights)
    np.testing.assert_allclose(lookahead(split, 3), lookahead(belief, 3), rtol=1e-12)
    np.testing.assert_allclose(split.expected_rewards(), belief.expected_rewards(), rtol=1e-12)
    rng = np.random.default_rng(0)
    after, later = (start.update(0, 1, rng).update(1, 0, rng) for start in (belief, split))
    np.testing.assert_allclose(later.weights @ later.states, after.weights @ after.states, rtol=1e-12)


def test_with_an_expertise_of_zero_costs_do_not_affect_the_choice() -> None:
    """The shortcut for novices draws like the general rule with beta = 0: the same tree."""
    model = small_model(0.0)
    general = replace(model, arrays=model.arrays._replace(even=False))
    belief = belief_in(general, np.array([[0.1, 0.6, 0.2]]), [1.0])
    first, other = (tree_of(replace(belief, model=m), pomcp(300, 0.01)) for m in (model, general))
    for a, b in zip(first, other, strict=True):
        np.testing.assert_array_equal(a, b)

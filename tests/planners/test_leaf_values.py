"""Leaf values against the returns they stand for, by enumeration; run as plain Python, so that nothing is compiled."""

import math
from dataclasses import replace

import numpy as np
import pytest
from plain_python import interpreted, plant_in_search
from scipy import stats
from small_problems import pomcp, random_tables, relaxed, small_model, table_belief, table_bound, tree_of

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.pomcp.tree import UNVISITED
from fatigue_planner.pomdp.problem import Pomdp

REVEALED = random_tables(5, actions=3, states=2, horizon=4, revealed=True)


def follow(problem: Pomdp, state: np.ndarray, cycles: int, greedily: bool) -> float:
    """Expected return of some cycles with random actions or, if `greedily`, those of the best expected reward."""
    if cycles == 0:
        return 0.0
    values, rewards = [], []
    for action in range(len(problem.actions)):
        value = reward_now = 0.0
        for outcome, chance in enumerate(problem.probabilities(state, action)):
            after, reward = problem.transition(state, action, outcome)
            reward_now += chance * reward
            value += chance * (reward + problem.discount * follow(problem, after, cycles - 1, greedily))
        values.append(value)
        rewards.append(reward_now)
    return values[int(np.argmax(rewards))] if greedily else float(np.mean(values))


@pytest.mark.parametrize(("leaf_value", "greedily"), [("random_rollout", False), ("greedy_rollout", True)])
def test_a_rollout_is_worth_what_its_policy_is_worth(
    monkeypatch: pytest.MonkeyPatch, leaf_value: str, greedily: bool
) -> None:
    """One descent: reward and discounted rollout of 2 cycles; t-test of 400 searches, false alarm 1e-6."""
    plant_in_search(monkeypatch)
    state = np.array([1.0, 0.0])
    expected = 0.0
    for outcome, chance in enumerate(REVEALED.probabilities(state, 0)):
        after, reward = REVEALED.transition(state, 0, outcome)
        expected += chance * (reward + REVEALED.discount * follow(REVEALED, after, 2, greedily))
    belief = table_belief(REVEALED, [0.0, 1.0])
    settings = pomcp(1, leaf_value=leaf_value, rollout_cycles=2)
    found = [tree_of(belief, settings, seed).value[0, 0] for seed in range(400)]
    assert stats.ttest_1samp(found, expected).pvalue > 1e-6


def test_a_greedy_rollout_of_an_expert_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is left to chance: the root's value is the return of the cycles, exactly."""
    plant_in_search(monkeypatch)
    belief = relaxed(small_model(math.inf))
    tree = tree_of(belief, pomcp(1, leaf_value="greedy_rollout", rollout_cycles=4))
    model, state = belief.model, belief.states[0]
    state, total = model.transition(state, 0, int(model.probabilities(state, 0).argmax()))
    assert tree.value[0, 0] == pytest.approx(total + 0.95 * follow(model, state, 4, greedily=True), rel=1e-12)


@pytest.mark.parametrize("backup", ["mean", "max", "exact"])
def test_a_bound_stands_at_every_leaf(monkeypatch: pytest.MonkeyPatch, backup: str) -> None:
    """Three descents, one per action: mean reward and the discounted bound of the state reached."""
    plant_in_search(monkeypatch)
    tree = tree_of(table_belief(REVEALED, [0.0, 1.0]), pomcp(3, 0.0, backup, leaf_value="bound"))
    for action in range(3):
        (outcome,) = np.flatnonzero(tree.child[0, action] != UNVISITED)
        after, reward = REVEALED.transition(np.array([1.0, 0.0]), action, int(outcome))
        if backup == "exact":
            reward = tree.mean_reward[0, action]
        expected = reward + REVEALED.discount * interpreted(table_bound)(REVEALED.arrays, after)
        assert tree.value[0, action] == pytest.approx(expected, rel=1e-12)


def test_a_problem_without_a_bound_says_so() -> None:
    without = replace(REVEALED, dynamics=replace(REVEALED.dynamics, bound=None))
    belief, rng = table_belief(without, [0.5, 0.5]), np.random.default_rng(0)
    for settings in (pomcp(9, leaf_value="bound"), LookaheadSettings(kind="lookahead", depth=1, leaf_value="bound")):
        with pytest.raises(ExperimentError, match="leaf value bound: this problem has none"):
            settings.build().act(belief, rng)

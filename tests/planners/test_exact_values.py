"""Lookahead and search against exact values found by other means: the tiger, and small random problems."""

import numpy as np
import pytest
import tiger
from scipy import stats
from small_problems import (
    lookahead,
    pomcp,
    random_tables,
    table_belief,
    table_value,
    tiger_with_an_end,
    tree_of,
)

from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.problem import draw

FALSE_ALARM = 1e-6


def tiger_values(on_the_left: float, steps: int) -> list[float]:
    """The tiger's exact values by Bellman's equation for the probability that it is on the left."""

    def best(chance: float) -> float:
        return max(tiger_values(chance, steps - 1)) if steps > 1 else 0.0

    heard_left = 0.85 * on_the_left + 0.15 * (1 - on_the_left)
    anew = 0.95 * best(0.5)
    listen = -1 + 0.95 * (
        heard_left * best(0.85 * on_the_left / heard_left)
        + (1 - heard_left) * best(0.15 * on_the_left / (1 - heard_left))
    )
    left = -100 * on_the_left + 10 * (1 - on_the_left)
    return [left + anew, -90 - left + anew, listen]


@pytest.mark.parametrize("steps", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("on_the_left", [0.5, 0.97])
def test_lookahead_is_exact_in_the_tiger_problem(on_the_left: float, steps: int) -> None:
    """The example's functions, and the tables with an end, against value iteration: to 1e-12."""
    exact = tiger_values(on_the_left, steps)
    weights = np.array([on_the_left, 1 - on_the_left])
    example = ExactBelief(tiger.PROBLEM, tiger.NO_IDEA.states, weights)
    np.testing.assert_allclose(lookahead(example, steps), exact, rtol=1e-12)
    ending = tiger_with_an_end(steps)
    np.testing.assert_allclose(table_value(ending, weights), exact, rtol=1e-12)
    for depth in (steps, steps + 1):
        np.testing.assert_allclose(lookahead(table_belief(ending, weights), depth), exact, rtol=1e-12)


@pytest.mark.parametrize("revealed", [False, True])
def test_lookahead_is_exact_in_random_problems(revealed: bool) -> None:
    """States observed or hidden, from several states at once."""
    for seed in range(5):
        problem = random_tables(seed, actions=3, states=2, horizon=4, revealed=revealed)
        weights = np.array([0.3, 0.7])
        assert problem.observation_reveals_outcome == revealed
        np.testing.assert_allclose(
            lookahead(table_belief(problem, weights), 4), table_value(problem, weights), rtol=1e-12
        )


def root_errors(backup: str, c: float, descents: int) -> np.ndarray:
    """Root values of 16 searches less the exact ones, (16, A): tiger with an end after 3 steps.

    Its tree is finite where it matters: beyond the end all returns are 0.
    """
    belief = table_belief(tiger_with_an_end(3), [0.5, 0.5])
    found = [tree_of(belief, pomcp(descents, c, backup), seed).value[0] for seed in range(16)]
    return np.array(found) - tiger_values(0.5, 3)


# The error that may remain after 48,000 descents; the returns differ by up to 300.
TOLERANCE = {"mean": 1.0, "max": 0.1, "exact": 0.1}


@pytest.mark.parametrize("backup", TOLERANCE)
def test_root_values_converge_to_the_exact_ones(backup: str) -> None:
    """The value of the best action: 16 times the descents leave less than a third of the error, or almost nothing.

    The error that remains is below the tolerance plus the width of the confidence interval of the mean of 16 searches:
    t, false alarm 1e-6. (Actions that are not the best are tried less and less often; see the next test.)
    """
    few, many = (root_errors(backup, 100.0, descents)[:, 2] for descents in (3000, 48_000))
    noise = stats.t.isf(FALSE_ALARM / 2, 15) * stats.sem(many)
    assert noise < 0.3 and abs(many.mean()) < TOLERANCE[backup] + noise
    assert abs(many.mean()) < abs(few.mean()) / 3 + TOLERANCE[backup] / 10


@pytest.mark.parametrize("backup", ["max", "exact"])
def test_with_much_exploration_the_values_of_all_actions_converge(backup: str) -> None:
    """t-test of 16 searches, false alarm 1e-6 for each of the 3 actions; tolerance 0.1."""
    errors = root_errors(backup, 1000.0, 48_000)
    noise = stats.t.isf(FALSE_ALARM / 2, 15) * stats.sem(errors)
    assert (noise < 4).all() and (np.abs(errors.mean(axis=0)) < 0.1 + noise).all()


def test_the_exact_backup_is_exact_once_the_tree_is_full() -> None:
    """From one state, seen at every step, no sampling error is left: root values to 1e-12, whatever c."""
    problem = random_tables(3, actions=2, states=2, horizon=3, revealed=True)
    belief, exact = table_belief(problem, [1.0, 0.0]), table_value(problem, np.array([1.0, 0.0]))
    for c in (30.0, 1000.0):
        np.testing.assert_allclose(tree_of(belief, pomcp(20_000, c, "exact")).value[0], exact, rtol=1e-12)


def returns(settings: PolicySettings, belief: ExactBelief, steps: int, games: int) -> np.ndarray:
    """Discounted returns of a policy in games of `steps` steps."""
    problem, rng = belief.model, np.random.default_rng(8)
    total = np.zeros(games)
    for game in range(games):
        policy, now = settings.build(), belief
        state = belief.states[draw(belief.weights, rng.random())]
        for step in range(steps):
            action = policy.act(now, rng).action
            outcome = draw(problem.probabilities(state, action), rng.random())
            state, reward = problem.transition(state, action, outcome)
            seen = draw(problem.observation_probabilities(state, action, outcome), rng.random())
            policy.observe(action, seen)
            now = now.update(action, seen, rng)
            total[game] += problem.discount**step * reward
    return total


SEARCH = pomcp(2000, 50.0, "max")


def test_the_policys_mean_return_is_the_exact_value() -> None:
    """Tiger over 4 steps: the exact value lies in the confidence interval of the mean of 300 games.

    t, false alarm 1e-6 (the skewed returns are bounded, and the seed is fixed).
    """
    found = returns(SEARCH, table_belief(tiger_with_an_end(4), [0.5, 0.5]), 4, 300)
    width = stats.t.isf(FALSE_ALARM / 2, found.size - 1) * stats.sem(found)
    assert width < 6 and abs(found.mean() - max(tiger_values(0.5, 4))) < width


def test_what_the_policy_does_is_worth_the_exact_value() -> None:
    """The same without chance: its decisions after every history, and the exact expectation of what they gain."""
    rng = np.random.default_rng(2)

    def worth(belief: ExactBelief, steps: int) -> float:
        if steps == 0:
            return 0.0
        action = pomcp(20_000, 50.0, "max").build().act(belief, rng).action
        value = float(belief.expected_rewards()[action])
        on_the_left = float(belief.weights @ (belief.states[:, 0] == 0))
        heard_left = 0.85 * on_the_left + 0.15 * (1 - on_the_left) if action == 2 else 0.5
        for observation, chance in enumerate((heard_left, 1 - heard_left)):
            value += 0.95 * chance * worth(belief.update(action, observation, rng), steps - 1)
        return value

    exact = max(tiger_values(0.5, 4))
    assert exact - 0.02 < worth(table_belief(tiger_with_an_end(4), [0.5, 0.5]), 4) < exact + 1e-9

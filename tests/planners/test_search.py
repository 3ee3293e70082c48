"""The search tree: answers worked out by hand, and what must hold for every tree."""

import math

import numpy as np
import pytest
from scipy import stats
from small_problems import (
    EXPERTISES,
    NOISY,
    expectimax,
    lookahead,
    pomcp,
    relaxed,
    small_model,
    tree_of,
    two_starts,
    two_workers,
    with_discount,
)
from tree_checks import (
    assert_counts,
    assert_exact_everywhere,
    assert_maxuct_everywhere,
    assert_means_everywhere,
    assert_observations_as_likely,
    children,
)

from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.pomcp.policy import PomcpPolicy
from fatigue_planner.reactions.reaction import Reaction

BACKUPS = ("mean", "max", "exact")


@pytest.mark.parametrize("backup", BACKUPS)
@pytest.mark.parametrize("expertise", EXPERTISES)
def test_tree_counts_add_up(backup: str, expertise: float) -> None:
    tree = tree_of(two_starts(small_model(expertise)), pomcp(500, backup=backup))
    assert_counts(tree, 500)
    assert (tree.value[tree.tried > 0] < 0).all()


@pytest.mark.parametrize("backup", BACKUPS)
def test_counts_add_up_where_workers_are_hidden_and_recognition_errs(backup: str) -> None:
    tree = tree_of(two_workers(NOISY), pomcp(500, 0.01, backup))
    assert_counts(tree, 500)


@pytest.mark.parametrize("backup", BACKUPS)
def test_without_future_a_search_is_greedy(backup: str) -> None:
    belief = with_discount(relaxed(small_model(math.inf)), 0.0)
    tree = tree_of(belief, pomcp(50, backup=backup))
    np.testing.assert_allclose(tree.value[0], [expectimax(belief, a, 1) for a in range(2)], rtol=1e-12)
    np.testing.assert_allclose(tree.value[0], lookahead(belief, 1), rtol=1e-12)


def test_golden_tree_by_hand() -> None:
    """Three descents in a problem without chance, worked out on paper.

    Descents 1 and 2 try a and b at the root. The third continues below the better one (c = 0) and tries
    a there. POMCP then holds the mean of the returns r and r + gamma r'; MaxUCT counts the successor's
    current value r' for both visits, and so does the exact backup.
    """
    belief = relaxed(small_model(math.inf))
    model = belief.model

    def step(state: np.ndarray, action: int) -> tuple[np.ndarray, float]:
        return model.transition(state, action, int(model.probabilities(state, action).argmax()))

    (after_a, r_a), (after_b, r_b) = step(belief.states[0], 0), step(belief.states[0], 1)
    after, r = (after_a, r_a) if r_a >= r_b else (after_b, r_b)
    best = 0 if r_a >= r_b else 1
    for backup, fraction in (("mean", 1 / 2), ("max", 1), ("exact", 1)):
        tree = tree_of(belief, pomcp(3, 0.0, backup))
        _, third = step(after, 0)
        np.testing.assert_allclose(tree.value[0, best], r + model.discount * third * fraction, rtol=1e-12)
        np.testing.assert_allclose(tree.value[0, 1 - best], r_b if best == 0 else r_a, rtol=1e-12)


def test_max_backup_is_maxuct_everywhere() -> None:
    """Every stored value obeys Q = mean reward + gamma * visit-weighted mean of the successors' best Q."""
    belief = relaxed(small_model(0.0))
    assert_maxuct_everywhere(tree_of(belief, pomcp(400, 0.02, "max")), belief)


@pytest.mark.parametrize("recognition", [None, NOISY])
def test_exact_backup_knows_the_chances_everywhere(recognition: np.ndarray | None) -> None:
    """Every value obeys the exact backup; from one state, seen without error, its means are the model's."""
    assert_exact_everywhere(tree_of(two_starts(small_model(25.0, recognition)), pomcp(400, 0.02, "exact")), 0.95)
    belief = relaxed(small_model(25.0, recognition))
    tree = tree_of(belief, pomcp(400, 0.02, "exact"))
    assert_exact_everywhere(tree, 0.95)
    np.testing.assert_allclose(tree.mean_reward[0], belief.expected_rewards(), rtol=1e-12)
    for action in range(2):
        outcomes = belief.model.probabilities(belief.states[0], action)
        np.testing.assert_allclose(tree.chance[0, action], outcomes @ belief.model.arrays.observation, rtol=1e-12)


def test_mean_backup_is_the_mean_of_the_returns_everywhere() -> None:
    belief = relaxed(small_model(25.0))
    assert_means_everywhere(tree_of(belief, pomcp(400, 0.02)), belief)


def test_one_step_values_are_unbiased() -> None:
    """With gamma = 0 the root values estimate the exact expected cost: z-test, false alarm 1e-6 per action."""
    belief = with_discount(two_starts(small_model(3.0)), 0.0)
    estimates = np.array([tree_of(belief, pomcp(400, 10.0), seed).value[0] for seed in range(200)])
    for action in range(2):
        z = (estimates[:, action].mean() - expectimax(belief, action, 1)) / stats.sem(estimates[:, action])
        assert abs(z) < stats.norm.isf(0.5e-6)


@pytest.mark.parametrize("backup", BACKUPS)
def test_observations_come_as_often_as_the_belief_says(backup: str) -> None:
    """So often that a quality of recognition that is wrong by 0.05 is seen."""
    belief, wrong = two_workers(NOISY), two_workers(NOISY - [[0.05, -0.05], [0.05, -0.05]])
    assert_observations_as_likely(tree_of(belief, pomcp(4000, 10.0, backup)), belief)
    with pytest.raises(AssertionError):
        assert_observations_as_likely(tree_of(wrong, pomcp(4000, 10.0, backup)), belief)


def test_pomcp_finds_the_exact_long_term_action(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """Where the exact lookahead clearly prefers an action, so does every search with many descents."""
    task = scenario(paper, cycle_profiles(paper, reactions), paper.benchmark.conditions["single_novice"])
    rng = np.random.default_rng(4)
    belief = task.initial_belief("prior", task.model, rng)
    for action in (1, 1, 1):
        belief = belief.update(action, 0, rng)
    exact = [expectimax(belief, a, 5) for a in range(2)]
    np.testing.assert_allclose(lookahead(belief, 5), exact, rtol=1e-12)
    assert abs(exact[0] - exact[1]) > 1e-4
    for backup in BACKUPS:
        decision = PomcpPolicy(pomcp(20_000, 0.1, backup)).act(belief, rng)
        assert decision.action == int(np.argmax(exact))


@pytest.mark.parametrize("backup", BACKUPS)
def test_without_chance_two_searches_are_the_same_whatever_the_generator(backup: str) -> None:
    belief = relaxed(small_model(math.inf))
    first, second = (tree_of(belief, pomcp(300, 0.01, backup), seed) for seed in (1, 2))
    assert first.tobytes() == second.tobytes()


@pytest.mark.parametrize("backup", BACKUPS)
def test_an_action_not_tried_does_not_count_as_zero(backup: str) -> None:
    """All rewards are negative: where one of two actions was tried below, the other one does not make the value 0."""
    belief = relaxed(small_model(math.inf))
    tree = tree_of(belief, pomcp(3, 0.0, backup))
    (node,) = (child for a in range(2) for child in children(tree, 0, a) if tree.tried[child].any())
    assert tree.tried[node].tolist() == [1, 0]
    assert tree.value[0, tree.tried[0].argmax()] < belief.expected_rewards().max() + tree.value[node, 0] / 3

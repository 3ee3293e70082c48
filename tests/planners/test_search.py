"""The search tree: answers worked out by hand, and what must hold for every tree."""

import math

import numpy as np
import pytest
from plain_python import plant_in_search
from scipy import stats
from small_problems import (
    EXPERTISES,
    NOISY,
    expectimax,
    lookahead,
    nodes_of,
    pomcp,
    relaxed,
    small_model,
    small_profiles,
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

from fatigue_planner.core.jit import kernel
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.pomcp import kernels, policy
from fatigue_planner.planners.pomcp.policy import PomcpPolicy
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, build_pomdp, one_worker
from fatigue_planner.pomdp.simd import move_along, put
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
        np.testing.assert_allclose(tree.chance[0, action], outcomes @ belief.model.arrays.observation[0], rtol=1e-12)


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


# --- what is fast gives the same as what is plain ------------------------------------------------------------------


def with_ties() -> FatiguePomdp:
    """An expert to whom both reactions to the second action cost the same."""
    profiles = small_profiles()
    profiles["b", "y"] = profiles["b", "x"]
    return build_pomdp("ab", "xy", profiles, np.zeros((1, 3)), one_worker(math.inf), 0.95)


def three_trees(model: FatiguePomdp, backup: str) -> list[np.ndarray]:
    """Of decisions that go on from each other's trees."""
    actor, rng, belief = (
        PomcpPolicy(pomcp(150, 0.01, backup, reuse_tree=True)),
        np.random.default_rng(3),
        relaxed(model),
    )
    trees = []
    for _ in range(3):
        tree = nodes_of(actor.tree(belief, rng, 0.0))
        trees += [np.array(tree[name]) for name in ("value", "best", "tried", "visited", "child")]
        action = int(tree.value[0].argmax())
        observation = int(tree.child[0, action].argmax())
        actor.observe(action, observation)
        belief = belief.update(action, observation, rng)
    return [*trees, np.array(rng.random())]


@pytest.mark.parametrize("backup", BACKUPS)
@pytest.mark.parametrize("kind", ["novice", "expert", "expert with ties"])
def test_steps_not_taken_again_and_compiled_code_change_no_bit(
    kind: str, backup: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = with_ties() if "ties" in kind else small_model(math.inf if kind == "expert" else 0.0)
    assert kernels.keeps_rewards(model) is (kind != "novice")
    fast = three_trees(model, backup)
    for module in (kernels, policy):
        monkeypatch.setattr(module, "keeps_rewards", lambda _model: False)
    plant_in_search(monkeypatch)
    for found, plain in zip(fast, three_trees(model, backup), strict=True):
        assert np.array_equal(found, plain)


@pytest.mark.parametrize("width", [8, 24, 80, 120])
def test_several_steps_at_once_are_one_after_the_other(width: int) -> None:
    rng = np.random.default_rng(width)
    gain, offset = rng.random((4, width)), rng.random((4, width))
    start, rows = rng.random(width + 1), np.array([3, 1, 0, 3, 2])
    state = start.copy()
    step_along(gain, offset, state, rows, 1, 4)
    for row in (1, 0, 3):
        start[:width] = gain[row] * start[:width] + offset[row]
    assert np.array_equal(state, start)
    step_along(gain, offset, state, rows, 2, 2)
    assert np.array_equal(state, start)


@kernel
def step_along(gain: np.ndarray, offset: np.ndarray, state: np.ndarray, rows: np.ndarray, begin: int, end: int) -> None:
    move_along(gain, offset, state, rows, begin, end)


@kernel
def put_row(state: np.ndarray, states: np.ndarray, row: int) -> None:
    put(state, states, row)


@pytest.mark.parametrize("width", [1, 7, 8, 17, 81])
def test_a_descent_begins_in_a_state_of_the_belief(width: int) -> None:
    """However the belief's states lie in memory; nothing beside the state is written."""
    states = np.random.default_rng(width).random((3, width))
    for laid_out in (states, np.asfortranarray(states), np.repeat(states, 2, axis=1)[:, ::2]):
        memory = np.full(width + 1, -1.0)
        put_row(memory[:width], laid_out, 1)
        assert memory.tolist() == [*states[1], -1.0]

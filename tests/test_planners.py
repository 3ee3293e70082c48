"""The policies: known answers, invariants of the tree, and compiled code equal to plain Python."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp
from scipy import stats
from test_pomdp import small_model

from fatigue_planner.experiment.resolve import cycle_maps, problem
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import AlternatingPolicy, GreedyPolicy, RandomPolicy
from fatigue_planner.planners.pomcp import PomcpPolicy
from fatigue_planner.planners.registry import POLICY_KINDS, PomcpSettings, build_policy
from fatigue_planner.planners.search import LANES, UNVISITED, Tree, search_model
from fatigue_planner.reactions.reaction import Reaction

START = Belief(np.array([[0.1, 0.6, 0.2], [0.4, 0.1, 0.3]]), np.array([0.3, 0.7]))
RELAXED = Belief(np.zeros((1, 3)), np.ones(1))


def tree_of(model: FatiguePomdp, belief: Belief, descents: int, c: float = 0.1, maximise: bool = False) -> Tree:
    return PomcpPolicy(model, descents, c, maximise).tree(belief, np.random.default_rng(1))


def expectimax(model: FatiguePomdp, belief: Belief, action: int, depth: int) -> float:
    """Exact value of an action with `depth` cycles to go and exact observations, by full enumeration."""
    value = -belief.expected_cost(model, action)
    if depth == 1:
        return value
    choice = belief.weights @ np.array([model.choice(state, action) for state in belief.states])
    for o in np.flatnonzero(choice):
        following = belief.update(model, action, int(o))
        best = max(expectimax(model, following, a, depth - 1) for a in range(len(model.actions)))
        value += model.discount * choice[o] * best
    return value


def test_alternating_takes_the_actions_in_turn() -> None:
    policy = AlternatingPolicy(small_model(0.0))
    assert [policy.act(RELAXED, np.random.default_rng(0)).action for _ in range(5)] == [0, 1, 0, 1, 0]


def test_random_is_uniform() -> None:
    """Binomial test; false alarm 1e-6 (and the seed is fixed)."""
    policy, rng = RandomPolicy(small_model(0.0)), np.random.default_rng(11)
    ones = sum(policy.act(RELAXED, rng).action for _ in range(10_000))
    assert stats.binomtest(ones, 10_000, 0.5).pvalue > 1e-6


@pytest.mark.parametrize("expertise", [0.0, 5.0, math.inf])
def test_greedy_is_the_one_step_optimum(expertise: float) -> None:
    model = small_model(expertise)
    decision = GreedyPolicy(model).act(START, np.random.default_rng(0))
    values = [expectimax(model, START, a, 1) for a in range(2)]
    np.testing.assert_allclose(decision.values, values)
    assert decision.action == int(np.argmax(values))


@pytest.mark.parametrize("maximise", [False, True])
@pytest.mark.parametrize("expertise", [0.0, 30.0, math.inf])
def test_tree_counts_add_up(maximise: bool, expertise: float) -> None:
    tree = tree_of(small_model(expertise), START, 500, maximise=maximise)
    used = int((tree.visited > 0).sum())
    assert used == 501  # one new node per descent
    assert tree.tried[0].sum() == 500
    np.testing.assert_array_equal(tree.tried[:used].sum(axis=1), tree.visited[:used] - 1)
    for node in range(used):
        for action in range(2):
            children = [c for c in tree.child[node, action] if c != UNVISITED]
            assert sum(tree.visited[c] for c in children) == tree.tried[node, action]
    assert (tree.value[tree.tried > 0] < 0).all()


@pytest.mark.parametrize("maximise", [False, True])
def test_without_future_pomcp_is_greedy(maximise: bool) -> None:
    from dataclasses import replace

    model = replace(small_model(math.inf), discount=0.0)
    tree = tree_of(model, RELAXED, 50, maximise=maximise)
    np.testing.assert_allclose(tree.value[0], [expectimax(model, RELAXED, a, 1) for a in range(2)], rtol=1e-12)


def test_golden_tree_by_hand() -> None:
    """Three descents of POMCP and POMCP-Max in a problem without chance, worked out on paper.

    Descents 1 and 2 try a and b at the root. The third goes on behind the better one (c = 0) and tries
    a there. POMCP then holds the mean of the returns r and r + gamma r'; MaxUCT counts the successor's
    current value r' for both visits.
    """
    model = small_model(math.inf)
    gamma = model.discount

    def step(state: np.ndarray, action: int) -> tuple[np.ndarray, float]:
        u = int(model.choice(state, action).argmax())
        after = model.next_fatigue(state, action)[u]
        return after, -float(model.cost(after))

    zero = np.zeros(3)
    (after_a, r_a), (after_b, r_b) = step(zero, 0), step(zero, 1)
    after, r = (after_a, r_a) if r_a >= r_b else (after_b, r_b)
    best = 0 if r_a >= r_b else 1
    for maximise in (False, True):
        tree = tree_of(model, RELAXED, 3, c=0.0, maximise=maximise)
        _, third = step(after, 0)
        q = r + gamma * third * (1 if maximise else 1 / 2)
        np.testing.assert_allclose(tree.value[0, best], q, rtol=1e-12)
        np.testing.assert_allclose(tree.value[0, 1 - best], r_b if best == 0 else r_a, rtol=1e-12)


def test_max_backup_is_maxuct_everywhere() -> None:
    """Every stored value obeys Q = mean reward + gamma * visit-weighted mean of the successors' best Q."""
    model = small_model(0.0)
    tree = tree_of(model, START, 400, c=0.02, maximise=True)
    for node in range(401):
        for action in range(2):
            if tree.tried[node, action] == 0:
                continue
            future = 0.0
            for child in tree.child[node, action]:
                if child != UNVISITED and tree.tried[child].any():
                    future += tree.visited[child] * tree.value[child][tree.tried[child] > 0].max()
            expected = tree.mean_reward[node, action] + model.discount * future / tree.tried[node, action]
            # a value is set when the node is on the path; its successors change only then, too
            assert tree.value[node, action] == pytest.approx(expected, rel=1e-12)


def test_one_step_values_are_unbiased() -> None:
    """With gamma = 0 the root values estimate the exact expected cost: z-test, false alarm 1e-6 per action."""
    from dataclasses import replace

    model = replace(small_model(3.0), discount=0.0)
    estimates = np.array(
        [PomcpPolicy(model, 400, 10.0, False).tree(START, np.random.default_rng(s)).value[0] for s in range(200)]
    )
    for action in range(2):
        exact = expectimax(model, START, action, 1)
        z = (estimates[:, action].mean() - exact) / (estimates[:, action].std(ddof=1) / np.sqrt(200))
        assert abs(z) < stats.norm.isf(0.5e-6)


def test_pomcp_finds_the_exact_long_term_action(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    """Where the exact lookahead clearly prefers an action, so does POMCP with many descents."""
    model, belief = problem(paper, cycle_maps(paper, reactions), paper.benchmark.conditions["single_novice"])
    for action in (1, 1, 1):
        belief = belief.update(model, action, 0)
    exact = [expectimax(model, belief, a, 5) for a in range(2)]
    assert abs(exact[0] - exact[1]) > 1e-4
    for maximise in (False, True):
        decision = PomcpPolicy(model, 20_000, 0.1, maximise).act(belief, np.random.default_rng(4))
        assert decision.action == int(np.argmax(exact))


def test_dropping_or_adding_dead_entries_changes_no_value() -> None:
    """Entries that no reaction loads: the search gives the same tree with and without them, and padded."""
    from dataclasses import replace

    model = small_model(10.0)
    extra = np.zeros((2, 2, 5))
    wider = replace(
        model,
        gain=np.concatenate([model.gain, extra + 0.5], axis=2),
        offset=np.concatenate([model.offset, extra], axis=2),
        live=np.arange(8),
    )
    assert search_model(model).gain.shape == (4, LANES) and search_model(wider).gain.shape == (4, 2 * LANES)
    start = Belief(np.pad(START.states, [(0, 0), (0, 5)]), START.weights)
    for small, wide in zip(tree_of(model, START, 300), tree_of(wider, start, 300), strict=True):
        np.testing.assert_allclose(small, wide, rtol=1e-12)


def test_without_chance_two_searches_are_the_same_whatever_the_generator() -> None:
    model = small_model(math.inf)
    policy = PomcpPolicy(model, 300, 0.01, True)
    one, two = (policy.tree(RELAXED, np.random.default_rng(seed)) for seed in (1, 2))
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)


SCRIPT = """
import json, math, sys
import numpy as np
sys.path.insert(0, sys.argv[1])
from test_planners import START, tree_of
from test_pomdp import NOISY, small_model
trees = []
for expertise in (0.0, 25.0, math.inf):
    for observation in (None, NOISY):
        for maximise in (False, True):
            tree = tree_of(small_model(expertise, observation), START, 200, 0.01, maximise)
            trees.append([array.tolist() for array in tree])
print(json.dumps(trees))
"""


def test_compiled_search_equals_plain_python_bit_for_bit() -> None:
    here = str(Path(__file__).parent)
    texts = []
    for disabled in ("0", "1"):
        environment = os.environ | {"NUMBA_DISABLE_JIT": disabled}
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT, here], env=environment, capture_output=True, text=True, check=True
        )
        texts.append(json.loads(done.stdout))
    assert texts[0] == texts[1]


def test_registry_builds_every_policy_of_the_paper(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    model, belief = problem(paper, cycle_maps(paper, reactions), paper.benchmark.conditions["single_novice"])
    kinds = set()
    for settings in paper.benchmark.policies.values():
        small = settings.model_copy(update={"descents": 50}) if isinstance(settings, PomcpSettings) else settings
        decision = build_policy(model, small).act(belief, np.random.default_rng(0))
        assert decision.action in (0, 1) and decision.values.shape == (2,)
        kinds.add(settings.kind)
    assert kinds == set(POLICY_KINDS)

"""The policies: baselines, what a decision reports, the reused tree, the time budget, and the registry."""

import math
import time

import numpy as np
import pytest
from scipy import stats
from small_problems import (
    EXPERTISES,
    expectimax,
    nodes_of,
    pomcp,
    random_tables,
    relaxed,
    small_model,
    table_belief,
    tree_of,
    two_starts,
)
from tree_checks import assert_counts, children

from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import AlternatingPolicy, GreedyPolicy, RandomPolicy
from fatigue_planner.planners.lookahead import LookaheadPolicy, LookaheadSettings
from fatigue_planner.planners.policy import POLICIES
from fatigue_planner.planners.pomcp.policy import PomcpPolicy, PomcpSettings
from fatigue_planner.planners.pomcp.tree import UNVISITED
from fatigue_planner.reactions.reaction import Reaction


def test_alternating_takes_the_actions_in_turn() -> None:
    policy, belief = AlternatingPolicy(), relaxed(small_model(0.0))
    assert [policy.act(belief, np.random.default_rng(0)).action for _ in range(5)] == [0, 1, 0, 1, 0]


def test_random_is_uniform() -> None:
    """Binomial test; false alarm 1e-6 (and the seed is fixed)."""
    policy, belief, rng = RandomPolicy(), relaxed(small_model(0.0)), np.random.default_rng(11)
    ones = sum(policy.act(belief, rng).action for _ in range(10_000))
    assert stats.binomtest(ones, 10_000, 0.5).pvalue > 1e-6


@pytest.mark.parametrize("expertise", EXPERTISES)
def test_greedy_is_the_one_step_optimum(expertise: float) -> None:
    belief = two_starts(small_model(expertise))
    decision = GreedyPolicy().act(belief, np.random.default_rng(0))
    values = [expectimax(belief, a, 1) for a in range(2)]
    np.testing.assert_allclose(decision.values, values)
    assert decision.action == int(np.argmax(values))


def test_registry_builds_every_policy_of_the_paper(paper: Experiment, reactions: tuple[Reaction, ...]) -> None:
    task = scenario(paper, cycle_profiles(paper, reactions), paper.benchmark.conditions["single_novice"])
    rng = np.random.default_rng(0)
    kinds = {"lookahead", "fixed", "periodic", "robust_periodic", "threshold", "pomcpow", "agent"}  # the paper has none
    for settings in paper.benchmark.policies.values():
        small = settings.model_copy(update={"descents": 50}) if isinstance(settings, PomcpSettings) else settings
        decision = small.build().act(task.initial_belief(settings.knows, task.model, rng), rng)
        assert decision.action in (0, 1) and decision.values.shape == (2,)
        kinds.add(settings.kind)
    assert kinds == set(POLICIES.kinds())


def test_decisions_report_what_they_are_based_on() -> None:
    """Values, visits, depth, time and reason of every kind of policy, against what is known about each."""
    belief, rng = two_starts(small_model(0.0)), np.random.default_rng(2)
    for policy, depth, reason in (
        (RandomPolicy(), 0, "drawn at random"),
        (AlternatingPolicy(), 0, "next in turn"),
        (GreedyPolicy(), 1, "best expected reward of one cycle"),
        (LookaheadPolicy(LookaheadSettings(kind="lookahead", depth=3)), 3, "best exact return of 3 cycles"),
    ):
        decision = policy.act(belief, rng)
        assert decision.visits.tolist() == [0, 0] and decision.depth == depth and decision.reason == reason
        assert np.isnan(decision.values).all() == (depth == 0) and decision.duration_s > 0
    begin = time.perf_counter()
    decision = PomcpPolicy(pomcp(200, 0.02, "max")).act(belief, rng)
    assert 0 < decision.duration_s <= time.perf_counter() - begin
    assert decision.visits.sum() == 200 and decision.action == decision.values.argmax()
    assert decision.reason == "best estimated return after 200 descents"
    assert decision.depth == depth_of(tree_of(belief, pomcp(200, 0.02, "max"), 2))
    single = PomcpPolicy(pomcp(1)).act(belief, rng)
    assert single.action == 0 and single.visits.tolist() == [1, 0] and np.isnan(single.values).tolist() == [False, True]


def depth_of(tree, node: int = 0) -> int:
    below = [depth_of(tree, child) for action in range(tree.tried.shape[1]) for child in children(tree, node, action)]
    return 1 + max(below) if below else 0


def assert_same_subtree(tree, root: int, kept) -> None:
    """Node by node the same from two roots: counts, values and all that the parts of the search keep."""
    pairs, seen = [(root, 0)], 0
    while pairs:
        old, new = pairs.pop()
        seen += 1
        for name in tree.dtype.names:
            if name != "child":
                np.testing.assert_array_equal(kept[name][new], tree[name][old], err_msg=name)
        np.testing.assert_array_equal(tree.child[old] == UNVISITED, kept.child[new] == UNVISITED)
        pairs += zip(*(nodes[nodes != UNVISITED].tolist() for nodes in (tree.child[old], kept.child[new])), strict=True)
    assert seen == len(kept) == tree.visited[root]


@pytest.mark.parametrize("backup", ["max", "exact"])
def test_the_kept_tree_is_the_subtree_and_the_search_goes_on_from_it(backup: str) -> None:
    settings = pomcp(400, 0.02, backup, reuse_tree=True, exploration="scaled" if backup == "max" else "fixed")
    policy, rng = PomcpPolicy(settings), np.random.default_rng(3)
    belief = two_starts(small_model(0.0))
    kept = 0
    for observation in (0, 1, 1):
        tree = nodes_of(policy.tree(belief, rng, 0.0))
        assert_counts(tree, 400 + kept)
        action = int(tree.visited[tree.child[0, :, observation]].argmax())
        child = int(tree.child[0, action, observation])
        policy.observe(action, observation)
        assert_same_subtree(tree, child, nodes_of(policy._tree))
        kept = int(tree.visited[child]) - 1
        assert kept > 50
        belief = belief.update(action, observation, rng)
    assert policy.act(belief, rng).visits.sum() == 400 + kept


def test_where_nothing_can_be_kept_the_search_starts_afresh() -> None:
    """An observation that the search never made; and a policy that does not reuse its tree."""
    belief, rng = relaxed(small_model(math.inf)), np.random.default_rng(3)
    unseen = 1 - int(belief.model.probabilities(belief.states[0], 0).argmax())
    for settings, observation in ((pomcp(50, reuse_tree=True), unseen), (pomcp(50), 1 - unseen)):
        policy = PomcpPolicy(settings)
        policy.act(belief, rng)
        policy.observe(0, observation)
        following = belief.update(0, observation, rng)
        assert policy.act(following, rng).visits.sum() == 50


def test_a_decision_uses_its_own_belief_even_if_the_policy_was_not_told_what_happened() -> None:
    """Without `observe` there is no tree to continue from: that of another belief would be wrong."""
    model, rng = small_model(math.inf), np.random.default_rng(3)
    for reuse in (False, True):
        policy = PomcpPolicy(pomcp(50, reuse_tree=reuse))
        policy.act(relaxed(model), rng)
        again, fresh = (
            actor.act(two_starts(model), np.random.default_rng(5)) for actor in (policy, PomcpPolicy(pomcp(50)))
        )
        assert again.visits.sum() == 50 and again.values.tolist() == fresh.values.tolist()


def test_a_time_budget_is_kept_and_used() -> None:
    """The quickest of some decisions ends in time (a busy machine may delay others), after a real search."""
    belief, rng = two_starts(small_model(0.0)), np.random.default_rng(3)
    policy = PomcpPolicy(PomcpSettings(kind="pomcp", backup="max", exploration_constant=0.02, seconds=0.05))
    PomcpPolicy(pomcp(1, backup="max")).act(belief, rng)  # loads what is compiled
    decisions = [policy.act(belief, rng) for _ in range(5)]
    assert min(decision.duration_s for decision in decisions) < 0.06
    assert max(decision.duration_s for decision in decisions) > 0.02
    for decision in decisions:
        assert decision.visits.sum() > 2 and decision.visits.min() > 0 and decision.depth > 1
    tree = nodes_of(policy.tree(belief, rng, time.perf_counter()))
    assert_counts(tree, int(tree.visited[0]) - 1)


@pytest.mark.parametrize("seconds", [1e-12, 1e-4])
def test_a_budget_too_short_for_anything_still_tries_every_action(seconds: float) -> None:
    settings = PomcpSettings(kind="pomcp", backup="max", exploration_constant=0.02, seconds=seconds)
    decision = PomcpPolicy(settings).act(two_starts(small_model(0.0)), np.random.default_rng(3))
    assert decision.visits.min() > 0 and np.isfinite(decision.values).all() and decision.depth >= 1


def test_a_policy_that_meets_another_problem_starts_with_memory_of_its_own() -> None:
    """Compiled code checks no bounds: a tree of other actions or observations would be read beyond its records."""
    policy, rng = PomcpPolicy(pomcp(50, reuse_tree=True)), np.random.default_rng(3)
    policy.act(table_belief(random_tables(1, actions=5, states=2, horizon=3, revealed=True), [0.5, 0.5]), rng)
    other = table_belief(random_tables(2, actions=2, states=7, horizon=3, revealed=True), np.full(7, 1 / 7))
    decision = policy.act(other, rng)
    assert decision.visits.shape == (2,) and decision.visits.sum() == 50


def test_a_lookahead_that_meets_another_problem_starts_with_memory_of_its_own() -> None:
    """Two problems of one size, but the beliefs of the second grow, as its observations tell less."""
    settings, rng = LookaheadSettings(kind="lookahead", depth=3), np.random.default_rng(3)
    policy = LookaheadPolicy(settings)
    revealing, doubtful = (
        table_belief(random_tables(1, actions=2, states=2, horizon=4, revealed=revealed), [0.5, 0.5])
        for revealed in (True, False)
    )
    policy.values(revealing, rng)
    assert policy.values(doubtful, rng).tolist() == LookaheadPolicy(settings).values(doubtful, rng).tolist()
    assert policy._memory is not None and len(policy._memory[0].weights) == 2 + 4 + 8 + 16


def test_a_search_with_a_time_limit_never_copies_its_tree() -> None:
    """Its memory is there from the start, so that no decision is late because the tree has grown."""
    policy = PomcpPolicy(PomcpSettings(kind="pomcp", backup="mean", exploration_constant=0.1, seconds=0.02))
    belief = two_starts(small_model(0.0))
    rng = np.random.default_rng(3)
    policy.act(belief, rng)
    first = policy._tree
    decision = policy.act(belief, rng)
    assert first is not None and policy._tree is first and first.nodes.size > 10 * decision.visits.sum()


def test_indices_that_the_problem_does_not_have_are_refused() -> None:
    belief, rng = two_starts(small_model(0.0)), np.random.default_rng(0)
    for action, observation in ((2, 0), (-1, 0), (0, 2), (0, -1)):
        with pytest.raises(IndexError, match="the problem has 2, numbered from 0"):
            belief.update(action, observation, rng)
    with pytest.raises(IndexError, match="action 5"):
        belief.model.sample_step(belief.states[0], 5, rng)

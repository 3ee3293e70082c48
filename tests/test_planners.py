"""The policies: baselines, what a decision tells, the kept tree, the time budget, and the registry."""

import time

import numpy as np
import pytest
from scipy import stats
from small_problems import EXPERTISES, cut, expectimax, pomcp, relaxed, small_model, tree_of, two_starts
from tree_checks import assert_counts, assert_maxuct_everywhere, children

from fatigue_planner.experiment.resolve import cycle_profiles, situation
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import AlternatingPolicy, GreedyPolicy, RandomPolicy
from fatigue_planner.planners.lookahead import LookaheadPolicy
from fatigue_planner.planners.pomcp import PomcpPolicy
from fatigue_planner.planners.registry import POLICY_KINDS, build_policy
from fatigue_planner.planners.search.tree import UNVISITED
from fatigue_planner.planners.settings import LookaheadSettings, PomcpSettings
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
    one = situation(paper, cycle_profiles(paper, reactions), paper.benchmark.conditions["single_novice"])
    rng = np.random.default_rng(0)
    kinds = {"lookahead"}  # the paper has none
    for settings in paper.benchmark.policies.values():
        small = settings.model_copy(update={"descents": 50}) if isinstance(settings, PomcpSettings) else settings
        decision = build_policy(small).act(one.initial_belief(settings.knows, one.model, rng), rng)
        assert decision.action in (0, 1) and decision.values.shape == (2,)
        kinds.add(settings.kind)
    assert kinds == set(POLICY_KINDS)


def test_decisions_tell_what_they_rest_on() -> None:
    """Values, visits, depth, time and reason of every kind of policy, against what is known of each."""
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
    one = PomcpPolicy(pomcp(1)).act(belief, rng)
    assert one.action == 0 and one.visits.tolist() == [1, 0] and np.isnan(one.values).tolist() == [False, True]


def depth_of(tree, node: int = 0) -> int:
    below = [depth_of(tree, child) for action in range(tree.tried.shape[1]) for child in children(tree, node, action)]
    return 1 + max(below) if below else 0

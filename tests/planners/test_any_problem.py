"""Problems with more than three functions: what is legal, what ends, what helps; continuous and many observations.

Run as plain Python, so that nothing is compiled; that compiled code does the same is seen in test_zoo.py.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from any_problem import (
    ASK,
    BACK,
    DISCOUNT,
    HELP,
    ON,
    TURN_BACK,
    ferry,
    ferry_values,
    line,
    run_plainly,
)
from any_problem import line_density as compiled_density
from plain_python import interpreted, plant_in_search
from small_problems import pomcp, random_tables, table_belief

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.pomcp.sparse import beliefs, policy
from fatigue_planner.planners.pomcp.sparse.policy import Search, SparsePolicy
from fatigue_planner.planners.pomcp.sparse.pomcpow import PomcpowSettings
from fatigue_planner.planners.pomcp.sparse.tree import NONE, SparseTree, new_tree, node_type
from fatigue_planner.planners.registry import policy as settings_of
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief

line_density = compiled_density.py_func  # type: ignore[attr-defined]
WIDE = {"observations_k": 2.0, "observations_alpha": 0.25, "actions_k": 1.0, "actions_alpha": 0.3}


@pytest.fixture(autouse=True)
def plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    run_plainly(monkeypatch)


def searched(belief: Belief, descents: int, c: float = 5.0, seed: int = 1, **others: Any) -> SparseTree:
    search = Search("mean", "fixed", c, "none", 20, descents, None)._replace(**others)
    return SparsePolicy(search).tree(belief, np.random.default_rng(seed), 0.0)


def used(tree: SparseTree) -> Any:
    return tree.nodes[: tree.used[0]].view(np.recarray)


def places(tree: SparseTree) -> Iterator[tuple[int, int]]:
    """Every node, and the place of the ferry's passenger there, which its history tells."""
    nodes, place = used(tree), {0: 0}
    for index in range(len(nodes)):
        if index:
            step = {ON: 1, BACK: -1}.get(int(nodes.action[index]), 0)
            place[index] = place[int(nodes.parent[index])] + step
        yield index, place[index]


# --- legal actions and ends ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("backup", ["mean", "max"])
@pytest.mark.parametrize("helped", [False, True])
def test_what_is_forbidden_is_never_tried(backup: str, helped: bool) -> None:
    """Neither in the tree nor in rollouts: `ferry_advance` would notice. Nothing lies beyond the end."""
    belief = ferry(**(HELP if helped else {}))
    tree = searched(belief, 300, backup=backup, leaf_value="random_rollout")
    legal = {0: [ON, ASK, TURN_BACK], 1: [BACK, ON]}
    seen = set()
    for index, place in places(tree):
        seen.add(place)
        forbidden = np.setdiff1d(np.arange(4), legal[place])
        assert not used(tree).tried[index][forbidden].any()
    assert seen == {0, 1}
    searched(belief, 50, leaf_value="greedy_rollout")


@pytest.mark.parametrize("steps", [1, 2, 3, 4])
def test_a_lookahead_knows_what_is_legal_and_what_ends(steps: int) -> None:
    """Exact values by recursion, to 1e-12; what is forbidden is worth -inf."""
    policy = LookaheadSettings(kind="lookahead", depth=steps).build()
    values = policy.act(ferry(), np.random.default_rng(0)).values
    exact = ferry_values(0.4, 0, steps)
    assert values[BACK] == -np.inf
    np.testing.assert_allclose(values[list(exact)], list(exact.values()), rtol=1e-12)


def test_every_policy_takes_a_legal_action() -> None:
    rng = np.random.default_rng(3)
    for kind in ("random", "alternating", "greedy"):
        actor = settings_of(kind).build()
        for _ in range(12):
            assert actor.act(ferry(), rng).action != BACK
    assert ferry().expected_rewards()[BACK] == -np.inf


def test_an_action_is_legal_if_every_possible_state_permits_it() -> None:
    belief = replace(ferry(), states=np.array([[0.0, 0.0], [1.0, 0.0]]), weights=np.array([0.6, 0.4]))
    assert belief.legal_actions().tolist() == [False, True, False, False]
    assert used(searched(belief, 40)).tried[0].tolist() == [0, 40, 0, 0]
    assert belief.update(BACK, 0, np.random.default_rng(0)).states.tolist() == [[0.0, 0.0]]
    nothing = ferry(is_legal=lambda _arrays, _state, _action: False)
    with pytest.raises(ProblemError, match="every action is forbidden"):
        searched(nothing, 10)


def test_who_goes_on_has_not_reached_an_end() -> None:
    """States in which the task has ended leave the belief: at the root of a search, and when it is updated."""
    belief = replace(ferry(), states=np.array([[0.0, 0.0], [2.0, 0.0]]))
    assert belief.going_on().weights.tolist() == [1.0]
    np.testing.assert_allclose(used(searched(belief, 3)).value[0][TURN_BACK], 1.0)
    on_the_bridge = replace(ferry(), states=np.array([[1.0, 0.0], [0.0, 0.0]]))
    assert on_the_bridge.update(ON, 0, np.random.default_rng(0)).states.tolist() == [[1.0, 0.0]]
    particles = ParticleBelief.begin(belief.model, belief.states).going_on()
    assert particles.weights.tolist() == [1.0] and particles.log_weights.tolist() == [0.0]
    with pytest.raises(ProblemError, match="the task has ended in every state"):
        searched(replace(belief, states=np.full((2, 2), 2.0)), 3)
    with pytest.raises(ProblemError, match="the task has ended in state"):
        belief.model.sample_step(np.array([2.0, 0.0]), ON, np.random.default_rng(0))
    with pytest.raises(ProblemError, match=r"state \[0.0, 0.0\] forbids action 'back'"):
        belief.model.sample_step(np.zeros(2), BACK, np.random.default_rng(0))


# --- preferred actions, rollouts, bounds --------------------------------------------------------------------------


def test_preferred_actions_begin_with_visits_and_a_value() -> None:
    """By hand, from one state: 4 visits of value 3 and one of the reward -0.1; the report counts real descents only."""
    sure = replace(ferry(prior=HELP["prior"]), states=np.zeros((1, 2)), weights=np.ones(1))
    tree = searched(sure, 3, c=0.0)
    assert tree.prior.tolist() == [0, 4, 0, 0]
    assert used(tree).tried[0].tolist() == [0, 5, 1, 1]
    np.testing.assert_allclose(used(tree).value[0], [0, (4 * 3 - 0.1) / 5, -0.5, 1.0])
    assert used(tree).tried[1].sum() == 4  # every new node has them, too
    decision = SparsePolicy(Search("mean", "fixed", 0.0, "none", 20, 3, None)).act(sure, np.random.default_rng(0))
    assert decision.visits.tolist() == [0, 1, 1, 1] and np.isnan(decision.values[BACK])


@pytest.mark.parametrize("backup", ["mean", "max"])
def test_an_action_known_only_by_its_prior_is_not_chosen(backup: str) -> None:
    sure = replace(ferry(prior=lambda *_: (9.0, 99.0)), states=np.zeros((1, 2)), weights=np.ones(1))
    search = SparsePolicy(Search(backup, "fixed", 0.0, "none", 20, 1, None))
    decision = search.act(sure, np.random.default_rng(0))
    assert decision.visits.tolist() == [0, 1, 0, 0] and decision.action == ON
    assert np.isnan(decision.values[[BACK, ASK, TURN_BACK]]).all()


def test_a_rollout_is_that_of_the_problem_and_ends_with_it() -> None:
    """By hand: to the bridge, then on to a ferry that works: -0.1 + 0.9 x 10; asking: 3 steps."""
    sure = replace(ferry(rollout=HELP["rollout"]), states=np.zeros((1, 2)), weights=np.ones(1))
    tree = searched(sure, 3, leaf_value="random_rollout")
    np.testing.assert_allclose(used(tree).value[0][ON], -0.1 + DISCOUNT * 10)
    np.testing.assert_allclose(used(tree).value[0][ASK], -0.5 + DISCOUNT * (-0.1 + DISCOUNT * 10))
    wrong = replace(ferry(rollout=lambda *_: 17), states=np.zeros((1, 2)), weights=np.ones(1))
    np.testing.assert_allclose(used(searched(wrong, 1, leaf_value="random_rollout")).value[0][ON], -0.1)


def test_a_bound_counts_until_the_end_and_reads_the_problems_arrays() -> None:
    sure = replace(ferry(bound=HELP["bound"]), states=np.zeros((1, 2)), weights=np.ones(1))
    assert replace(sure.model, arrays=(1.0,)).bound_arrays == (1.0,)
    values = used(searched(sure, 3, leaf_value="bound")).value[0]
    np.testing.assert_allclose(values, [0, -0.1 + DISCOUNT * 3, -0.5 + DISCOUNT * 2, 1.0])
    policy = LookaheadSettings(kind="lookahead", depth=1, leaf_value="bound").build()
    np.testing.assert_allclose(policy.act(sure, np.random.default_rng(0)).values[1:], values[1:])


# --- the sparse tree ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("backup", "exploration", "leaf"),
    [("mean", "fixed", "none"), ("max", "scaled", "random_rollout"), ("max", "fixed", "bound")],
)
def test_the_sparse_tree_is_the_dense_one(
    monkeypatch: pytest.MonkeyPatch, backup: str, exploration: str, leaf: str
) -> None:
    """In a problem of three functions: node by node, to the last bit; and it grows, which changes nothing."""
    plant_in_search(monkeypatch)
    monkeypatch.setattr(policy, "MOST_AT_FIRST", 20)
    belief = table_belief(random_tables(5, actions=3, states=2, horizon=4, revealed=False), [0.3, 0.7])
    settings = pomcp(150, 0.5, backup, exploration=exploration, leaf_value=leaf, rollout_cycles=3)
    dense = settings.build().tree(belief, np.random.default_rng(2), 0.0)  # type: ignore[attr-defined]
    options = {"exploration": exploration, "leaf_value": leaf, "rollout_cycles": 3, "backup": backup}
    sparse = searched(belief, 150, 0.5, 2, **options)
    assert sparse.used[0] == dense.size[0] == 151
    for field in ("value", "best", "visited", "tried"):
        assert sparse.nodes[field][:151].tobytes() == np.ascontiguousarray(dense.nodes[field][:151]).tobytes()


def test_a_problem_of_many_observations_needs_little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(policy, "MAX_DENSE_CHILDREN", 5)
    assert policy.needs_a_sparse_tree(random_tables(5, 3, 2, 4, revealed=False))
    assert node_type(3, with_spread=False).itemsize < 200
    made = new_tree(1001, node_type(3, with_spread=False), 1, 0, 2)
    assert sum(part.nbytes for part in made) < 300_000


# --- widening and beliefs in nodes --------------------------------------------------------------------------------


def widened(descents: int, seed: int = 1, **constants: float) -> SparseTree:
    settings = PomcpowSettings(
        kind="pomcpow", exploration_constant=5.0, leaf_value="none", descents=descents, **constants
    )
    return settings.build().tree(line(), np.random.default_rng(seed), 0.0)  # type: ignore[attr-defined]


def particles_of(tree: SparseTree, index: int) -> list[int]:
    """The places of a node's particles in the pool, oldest first."""
    node, found = used(tree)[index], []
    first, base, count = int(node.chunk), int(node.older), int(node.particles - node.older)
    while True:
        found = [*range(first, first + count), *found]
        if base == 0:
            return found
        first, base, count = int(tree.before[first]), base // 2, base - base // 2


def test_observations_and_actions_widen_with_the_visits(monkeypatch: pytest.MonkeyPatch) -> None:
    """At most k N^alpha observations and one below an action, and so many actions in a node; all adds up."""
    monkeypatch.setattr(policy, "MOST_AT_FIRST", 20)
    tree = widened(400, **WIDE)
    nodes = used(tree)
    assert nodes.tried[0].sum() == 400
    for index in range(len(nodes)):
        for action in range(3):
            tried, children = int(nodes.tried[index, action]), int(nodes.children[index, action])
            assert children <= 2.0 * max(tried - 1, 0) ** 0.25 + 1
            below, child = [], int(nodes.first[index, action])
            while child != NONE:
                below.append(child)
                child = int(nodes.sibling[child])
            assert len(below) == children
            assert nodes.drawn[below].sum() == nodes.drawn_below[index, action] >= children
            assert nodes.particles[below].sum() == tried
        assert (nodes.tried[index] > 0).sum() <= max(1.0, float(nodes.visited[index]) ** 0.3)
    assert (nodes.tried[0] > 0).all() and nodes.children[0].max() > 2


def test_beliefs_in_nodes_weigh_states_by_what_was_seen() -> None:
    """The weight of every particle is the density of the node's observation in its state; rewards go with states."""
    tree = widened(200, **WIDE)
    nodes = used(tree)
    for index in range(1, len(nodes)):
        places = particles_of(tree, index)
        assert len(places) == nodes.particles[index]
        weights = np.diff([0.0, *tree.sums[places]])
        expected = [line_density(None, tree.particles[place], 0, 0, tree.seen[index]) for place in places]
        np.testing.assert_allclose(weights, expected, rtol=1e-9, atol=1e-12)
        np.testing.assert_array_equal(tree.rewards[places], -np.abs(tree.particles[places, 0]))
    assert int(tree.used[1]) <= 2 * sum(nodes.particles)


def test_a_descent_goes_on_from_a_state_of_the_nodes_belief() -> None:
    """The place is seen without error, so the belief of every node is one place: all come from what its parent saw."""

    def see_exactly(_arrays: Any, state: np.ndarray, _a: int, _u: int, seen: np.ndarray, _rng: Any) -> None:
        seen[0], seen[1] = state[0], 0.0

    def certainty(_arrays: Any, state: np.ndarray, _a: int, _u: int, seen: np.ndarray) -> float:
        return 1.0 if seen[0] == state[0] else 0.0

    start = line(observation_probability=certainty, draw_observation=see_exactly)
    settings = PomcpowSettings(kind="pomcpow", exploration_constant=5.0, leaf_value="none", descents=300, **WIDE)
    tree = settings.build().tree(start, np.random.default_rng(1), 0.0)  # type: ignore[attr-defined]
    nodes, deeper = used(tree), 0
    for index in range(1, len(nodes)):
        if nodes.parent[index] > 0:
            come = tree.particles[particles_of(tree, index), 0]
            moves = come - tree.seen[nodes.parent[index], 0] - (int(nodes.action[index]) - 1)
            assert set(moves.tolist()) <= {0.0, 0.5}
            deeper += come.size
    assert deeper > 100


def test_a_particle_is_drawn_by_its_weight() -> None:
    """Every draw against the running sum of the weights; weights of 0, and such as are no number, are never drawn."""
    add, draw = interpreted(beliefs.add_particle), interpreted(beliefs.draw_particle)
    tree = new_tree(3, node_type(2, with_spread=False), 1, 400, 1)
    tree = tree._replace(nodes=tree.nodes.view(np.recarray))
    rng = np.random.default_rng(4)
    kept: dict[int, list[float]] = {1: [], 2: []}
    for turn in range(100):
        index = 1 + int(rng.random() < 0.4)
        weight = [np.nan, 0.0, np.inf, -1.0][turn % 4] if turn % 7 == 3 else rng.random()
        add(tree, index, np.array([float(len(kept[index]))]), 0.0, weight)
        kept[index].append(weight if np.isfinite(weight) and weight > 0 else 0.0)
        sums = np.cumsum(kept[index])
        for uniform in (0.0, 0.25, rng.random(), 1 - 1e-12):
            chosen = int(tree.particles[draw(tree, index, uniform), 0])
            if sums[-1] > 0:
                assert chosen == np.searchsorted(sums, uniform * sums[-1], side="right")
                assert kept[index][chosen] > 0


def test_a_search_with_continuous_observations_is_that_of_its_seed() -> None:
    first, second, other = widened(80), widened(80), widened(80, seed=2)
    assert used(first).tobytes() == used(second).tobytes() != used(other).tobytes()


# --- what is refused ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (pomcp(9), "pomcp has a node for every observation; .* use pomcpow"),
        (pomcp(9, backup="exact"), "backup exact knows the probability of every observation"),
        (pomcp(9, reuse_tree=True), "reuse_tree: a tree is not reused"),
        (LookaheadSettings(kind="lookahead", depth=1), "lookahead goes through every observation; .* use pomcpow"),
    ],
    ids=["pomcp", "exact", "reuse_tree", "lookahead"],
)
def test_what_does_not_fit_continuous_observations_says_so(settings: Any, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        settings.build().act(line(), np.random.default_rng(0))


def test_beliefs_know_continuous_observations() -> None:
    """Bayes' rule with a density, by hand; an observation of another form is refused."""
    belief, seen = line(), np.array([0.3, 0.9])
    after = belief.update(2, seen, np.random.default_rng(0))
    moved = belief.states[:, 0] + 1
    weights = {}
    for outcome, chance in enumerate((0.75, 0.25)):
        for place in moved:
            state = np.array([place + 0.5 * outcome])
            weights[float(state[0])] = chance * line_density(None, state, 2, outcome, seen)
    assert after.states[:, 0].tolist() == sorted(weights)
    expected = np.array([weights[place] for place in sorted(weights)])
    np.testing.assert_allclose(after.weights, expected / expected.sum(), rtol=1e-12)
    for wrong in (np.zeros(3), 0.5, None):
        with pytest.raises(IndexError, match="the problem's are not such"):
            belief.update(2, wrong, np.random.default_rng(0))
    _, drawn, _ = belief.model.sample_step(np.zeros(1), 1, np.random.default_rng(0))
    assert drawn.shape == (2,)


def wrong_at_home(_arrays: Any, state: np.ndarray, _action: int, probabilities: np.ndarray) -> None:
    probabilities[0] = 1.0 if state[0] == 1 else 0.7


def test_chances_are_checked_in_every_state_that_is_met(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first belief holds right states only; the wrong one comes later, to each of those who use probabilities."""
    plant_in_search(monkeypatch)
    functions = replace(ferry().model.dynamics, outcome_probabilities=wrong_at_home)
    for dynamics in (functions, replace(functions, is_legal=None, is_terminal=None, advance=lambda *_: 0.0)):
        problem = replace(ferry().model, dynamics=dynamics)
        bridge, home = (ExactBelief(problem, np.array([[place, 0.0]]), np.ones(1)) for place in (1.0, 0.0))
        message, rng = r"in state \[0.0, 0.0\] sum to 0.7", np.random.default_rng(0)
        for settings in ("greedy", {"kind": "lookahead", "depth": 1}, pomcp(5)):
            actor = settings_of(settings).build()
            actor.act(bridge, rng)
            with pytest.raises(ProblemError, match=message):
                actor.act(home, rng)
        for update in (home.update, ParticleBelief.begin(problem, home.states).update):
            with pytest.raises(ProblemError, match=message):
                update(ON, 0, rng)
        with pytest.raises(ProblemError, match=message):
            problem.sample_step(home.states[0], ON, rng)

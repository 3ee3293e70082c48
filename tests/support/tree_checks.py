"""What must hold for every search tree and every belief, whatever the problem; each check raises AssertionError."""

from collections.abc import Callable, Iterator, Sequence
from itertools import product

import numpy as np
import pytest
from scipy import stats
from small_problems import Nodes, nodes_with_tried

from fatigue_planner.planners.pomcp.tree import UNVISITED
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.problem import Pomdp


def children(tree: Nodes, node: int, action: int) -> list[int]:
    return [int(child) for child in tree.child[node, action] if child != UNVISITED]


def assert_counts(tree: Nodes, descents: int) -> None:
    """One node per descent; visits of a node are its creation and its actions', of an action its successors'."""
    used = len(tree)
    assert used == descents + 1 and tree.visited[0] == used
    assert (tree.visited > 0).all()
    np.testing.assert_array_equal(tree.tried.sum(axis=1), tree.visited - 1)
    parents = np.zeros(used, int)
    for node, action in nodes_with_tried(tree):
        following = children(tree, node, action)
        parents[following] += 1
        assert sum(int(tree.visited[child]) for child in following) == tree.tried[node, action]
    assert parents[0] == 0 and (parents[1:] == 1).all()


def best_tried(tree: Nodes, node: int) -> float:
    """V(h) as the search stores it: of a leaf its leaf value, else the best of the actions tried."""
    tried = tree.tried[node] > 0
    return float(tree.value[node][tried].max() if tried.any() else tree.best[node])


def assert_exact_everywhere(tree: Nodes, discount: float) -> None:
    """The same with the probabilities of the known observations in place of visits."""
    for node, action in nodes_with_tried(tree):
        chances = tree.chance[node, action]
        assert chances.sum() == pytest.approx(1, abs=1e-12)
        known = [o for o, child in enumerate(tree.child[node, action]) if child != UNVISITED]
        future = sum(chances[o] * best_tried(tree, int(tree.child[node, action, o])) for o in known)
        expected = tree.mean_reward[node, action] + discount * future / chances[known].sum()
        assert tree.value[node, action] == pytest.approx(expected, rel=1e-12, abs=1e-300)


def assert_means_everywhere(tree: Nodes, start: Belief) -> None:
    """N(h, a) Q(h, a) = sum of all rewards and, discounted, of all returns below, including leaf values."""
    _assert_sums(tree, start, lambda child: float(tree.tried[child] @ tree.value[child]) + tree.best[child])


def assert_maxuct_everywhere(tree: Nodes, start: Belief) -> None:
    """Q(h, a) = mean reward + gamma * mean over visits of the successors' V = best Q, of a leaf its leaf value."""
    _assert_sums(tree, start, lambda child: int(tree.visited[child]) * best_tried(tree, child))
    for node in range(len(tree)):
        assert tree.best[node] == best_tried(tree, node)


def _assert_sums(tree: Nodes, start: Belief, behind: Callable[[int], float]) -> None:
    """N(h, a) Q(h, a) = sum over the visits of the rewards + gamma * the return below every successor.

    From one state, with observations that reveal the outcome, so that all rewards follow from the tree.
    """
    model = start.model
    assert model.observation_reveals_outcome and len(start.weights) == 1
    stack = [(0, start.states[0])]
    while stack:
        node, state = stack.pop()
        for action in np.flatnonzero(tree.tried[node]):
            total = 0.0
            for outcome, child in enumerate(tree.child[node, action].tolist()):
                if child != UNVISITED:
                    after, reward = model.transition(state, int(action), outcome)
                    total += int(tree.visited[child]) * reward + model.discount * behind(child)
                    stack.append((child, after))
            assert tree.value[node, action] * int(tree.tried[node, action]) == pytest.approx(total, rel=1e-9)


def assert_observations_as_likely(tree: Nodes, belief: Belief) -> None:
    """Visits of the root's successors against P(o | b, a): chi-square test, false alarm 1e-6 per action."""
    model = belief.model
    for action in range(len(model.actions)):
        chances = np.zeros(len(model.observations))
        for state, weight in zip(belief.states, belief.weights, strict=True):
            for outcome, probability in enumerate(model.probabilities(state, action)):
                after, _ = model.transition(state, action, outcome)
                chances += weight * probability * model.observation_probabilities(after, action, outcome)
        seen = np.array([0 if child == UNVISITED else tree.visited[child] for child in tree.child[0, action]])
        assert not seen[chances == 0].any()
        likely = chances > 0
        assert stats.chisquare(seen[likely], chances[likely] / chances.sum() * seen.sum()).pvalue > 1e-6


def histories(model: Pomdp, length: int) -> Iterator[tuple[int, ...]]:
    return product(range(len(model.outcomes)), repeat=length)


def assert_bayes(start: Belief, actions: Sequence[int], seen: Sequence[int], model: Pomdp | None = None) -> None:
    """Filtering step by step equals summing over all states and all sequences of hidden outcomes.

    Compared are first and second moments of the state. `model` is the true one, where it is not the belief's.
    """
    model, belief, rng = model or start.model, start, np.random.default_rng(0)
    for action, o in zip(actions, seen, strict=True):
        belief = belief.update(action, o, rng)
    mass, mean, square = 0.0, 0.0, 0.0
    for state, weight in zip(start.states, start.weights, strict=True):
        for path in histories(model, len(actions)):
            chance, moved = float(weight), state
            for action, u, o in zip(actions, path, seen, strict=True):
                chance *= model.probabilities(moved, action)[u]
                moved, _ = model.transition(moved, action, u)
                chance *= model.observation_probabilities(moved, action, u)[o]
            mass, mean, square = mass + chance, mean + chance * moved, square + chance * moved**2
    assert belief.weights.sum() == pytest.approx(1)
    np.testing.assert_allclose(belief.weights @ belief.states, mean / mass, rtol=1e-12)
    np.testing.assert_allclose(belief.weights @ belief.states**2, square / mass, rtol=1e-12)

"""The kernel of the tree search: a template into which a problem's functions and the search's parts are put.

A descent samples a state from the belief, follows the exploration rule and the generative model (paper,
Fig. 4) through the tree to the leaf it adds (paper, section III-D), takes the leaf's value, and the
backup carries what was found to the root.
"""

from typing import Any, NamedTuple

import numpy as np

from fatigue_planner.planners.search.tree import UNVISITED, Array, Tree, Vector
from fatigue_planner.pomdp.problem import draw, step


class Numbers(NamedTuple):
    """The numbers a search goes by. log_root[n] = sqrt(log n) and inverse_root[n] = 1 / sqrt(n) are tables."""

    exploration_constant: float
    discount: float
    rollout_cycles: int
    outcomes: int
    log_root: Vector
    inverse_root: Vector
    bound_arrays: Any


def tables(capacity: int) -> tuple[Vector, Vector]:
    """sqrt(log n) and 1 / sqrt(n) for n = 0 ... capacity; the entries of n = 0 are never read."""
    n = np.arange(1, capacity + 1)
    return np.concatenate([[0.0], np.sqrt(np.log(n))]), np.concatenate([[0.0], 1 / np.sqrt(n)])


def select_action(tree: Tree, node: int, times: int, numbers: Numbers) -> int:
    """Stands for the exploration rule."""
    raise NotImplementedError


def expect(
    arrays: Any, tree: Tree, node: int, action: int, state: Vector, moved: Vector, scratch: Vector, certain: bool
) -> None:
    """Stands for what the backup wants to know before an action is taken."""
    raise NotImplementedError


def leaf_value(
    arrays: Any, state: Vector, moved: Vector, scratch: Vector, numbers: Numbers, actions: int, rng: np.random.Generator
) -> float:
    """Stands for the value of a new leaf."""
    raise NotImplementedError


def back_up(tree: Tree, node: int, action: int, reward: float, gained: float, discount: float) -> None:
    """Stands for the backup of a chance node; `gained` is the descent's return from it on."""
    raise NotImplementedError


def note_return(tree: Tree, node: int, gained: float) -> None:
    """Stands for what the exploration rule keeps of the returns from a node."""
    raise NotImplementedError


def grow(
    arrays: Any,
    states: Array,
    weights: Vector,
    tree: Tree,
    descents: int,
    numbers: Numbers,
    rng: np.random.Generator,
) -> int:
    """Template: grow a tree by a number of descents from a belief (states (n, L), weights (n,)); its depth.

    The tree must have room for as many nodes. Equal scores go to the first action, so a problem without
    chance has one tree, whatever the generator.
    """
    scratch = np.empty(numbers.outcomes)
    state, moved = np.empty(states.shape[1]), np.empty(states.shape[1])
    longest = tree.used[0] + descents
    nodes, taken = np.empty(longest, np.int32), np.empty(longest, np.int32)
    rewards = np.empty(longest)
    child, tried, visited = tree.child, tree.tried, tree.visited
    certain = weights.size == 1
    deepest = 0
    for _ in range(descents):
        particle = 0 if certain else draw(weights, rng.random())
        for j in range(state.size):
            state[j] = states[particle, j]
        node, depth = 0, 0
        while True:
            action = select_action(tree, node, visited[node] - 1, numbers)
            expect(arrays, tree, node, action, state, moved, scratch, certain)
            observation, reward = step(arrays, state, action, scratch, rng)
            nodes[depth], taken[depth], rewards[depth] = node, action, reward
            depth += 1
            visited[node] += 1
            successor = child[node, action, observation]
            if successor == UNVISITED:
                break
            node = successor
        leaf = tree.used[0]
        child[node, action, observation] = leaf
        visited[leaf] = 1
        tree.used[0] = leaf + 1
        gained = leaf_value(arrays, state, moved, scratch, numbers, tried.shape[1], rng)
        tree.best[leaf] = gained
        deepest = max(deepest, depth)
        for level in range(depth - 1, -1, -1):
            node, action = nodes[level], taken[level]
            gained = rewards[level] + numbers.discount * gained
            tried[node, action] += 1
            back_up(tree, node, action, rewards[level], gained, numbers.discount)
            note_return(tree, node, gained)
    return deepest

"""The search tree: a struct of arrays.

A decision node is a history h of (action, observation) pairs; node 0 is the belief searched from. Per
node h and action a (a chance node) and, where it says so, observation o:
    child[h, a, o]        the node of history (h, a, o), or UNVISITED
    tried[h, a]           how often a was chosen in h
    visited[h]            how often h was reached, its creation included; visited - 1 = sum of tried
    value[h, a]           estimated return of choosing a in h
    mean_reward[h, a]     mean immediate reward of a in h
    best[h]               value of h: its leaf value, once an action was tried what the backup makes of these
    chance[h, a, o]       known chance of o (exact backup only; else of size 0)
    spread[h]             sum of squared deviations of the returns from h (scaled exploration only; else of size 0)
    average[h]            mean of the returns from h (as spread)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.compiled import compiled

Vector = NDArray[np.float64]
Array = NDArray[np.float64]
Counts = NDArray[np.int32]

UNVISITED = -1


class Tree(NamedTuple):
    """The arrays described above, sized for a number of nodes; `used` (1,) says how many there are."""

    child: Counts
    tried: Counts
    visited: Counts
    value: Array
    mean_reward: Array
    best: Vector
    chance: Array
    spread: Vector
    average: Vector
    used: Counts


@compiled
def new_tree(capacity: int, actions: int, observations: int, with_chances: bool, with_spread: bool) -> Tree:
    """A tree of the root alone, with room for `capacity` nodes."""
    visited, used = np.zeros(capacity, np.int32), np.ones(1, np.int32)
    visited[0] = 1
    return Tree(
        np.full((capacity, actions, observations), UNVISITED, np.int32),
        np.zeros((capacity, actions), np.int32),
        visited,
        np.zeros((capacity, actions)),
        np.zeros((capacity, actions)),
        np.zeros(capacity),
        np.zeros((capacity if with_chances else 0, actions, observations)),
        np.zeros(capacity if with_spread else 0),
        np.zeros(capacity if with_spread else 0),
        used,
    )


@compiled
def copy_node(source: Tree, node: int, target: Tree, place: int) -> None:
    """Copy what a node knows of itself; its children are left out."""
    target.tried[place], target.visited[place] = source.tried[node], source.visited[node]
    target.value[place], target.mean_reward[place] = source.value[node], source.mean_reward[node]
    target.best[place] = source.best[node]
    if source.chance.shape[0] > 0:
        target.chance[place] = source.chance[node]
    if source.spread.size > 0:
        target.spread[place], target.average[place] = source.spread[node], source.average[node]


@compiled
def copy_subtree(source: Tree, root: int, target: Tree) -> None:
    """Copy a node and all below it to the root of an empty tree with room for them."""
    origin = np.empty(source.used[0], np.int32)
    origin[0] = root
    copied, used = 0, 1
    while copied < used:
        node = origin[copied]
        copy_node(source, node, target, copied)
        for action in range(source.child.shape[1]):
            for observation in range(source.child.shape[2]):
                successor = source.child[node, action, observation]
                if successor != UNVISITED:
                    target.child[copied, action, observation] = used
                    origin[used] = successor
                    used += 1
        copied += 1
    target.used[0] = used

"""The max backup: POMCP-Max (paper, section III-D), which is MaxUCT (Keller & Helmert 2013) on histories."""

import numpy as np

from fatigue_planner.compiled import compiled
from fatigue_planner.planners.search.tree import UNVISITED, Tree


@compiled
def best_value(tree: Tree, node: int) -> float:
    """V(h): the best of the actions tried; an action not yet tried does not count as 0."""
    best = -np.inf
    for action in range(tree.tried.shape[1]):
        if tree.tried[node, action] > 0 and tree.value[node, action] > best:
            best = tree.value[node, action]
    return best


@compiled
def back_up_max(tree: Tree, node: int, action: int, reward: float, _gained: float, discount: float) -> None:
    """Q(h, a) = mean reward + gamma * mean over the visits of the successors' current V.

    V(h) = max over the actions tried of Q(h, a); of a leaf, its leaf value.
    """
    times = tree.tried[node, action]
    tree.mean_reward[node, action] += (reward - tree.mean_reward[node, action]) / times
    future = 0.0
    for observation in range(tree.child.shape[2]):
        successor = tree.child[node, action, observation]
        if successor != UNVISITED:
            future += tree.visited[successor] * tree.best[successor]
    tree.value[node, action] = tree.mean_reward[node, action] + discount * future / times
    tree.best[node] = best_value(tree, node)

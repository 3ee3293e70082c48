"""UCB1 with a fixed exploration constant (paper, section III-D)."""

import numpy as np

from fatigue_planner.compiled import compiled
from fatigue_planner.planners.search.descent import Numbers
from fatigue_planner.planners.search.tree import Tree


@compiled
def ucb1(tree: Tree, node: int, times: int, scale: float, numbers: Numbers) -> int:
    """The first action not tried yet, else argmax value + scale * sqrt(log N(h) / N(h, a))."""
    best, best_score = 0, -np.inf
    bonus = scale * numbers.log_root[times]
    for action in range(tree.tried.shape[1]):
        tried = tree.tried[node, action]
        if tried == 0:
            return action
        score = tree.value[node, action] + bonus * numbers.inverse_root[tried]
        if score > best_score:
            best, best_score = action, score
    return best


@compiled
def select_fixed(tree: Tree, node: int, times: int, numbers: Numbers) -> int:
    """UCB1 with the constant as it is."""
    return int(ucb1(tree, node, times, numbers.exploration_constant, numbers))


@compiled
def note_nothing(_tree: Tree, _node: int, _gained: float) -> None:
    """A fixed constant needs nothing of the returns."""

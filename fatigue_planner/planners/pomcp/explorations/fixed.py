"""UCB1 with a fixed exploration constant (paper, section III-D)."""

import numpy as np

from fatigue_planner.core.jit import inlined
from fatigue_planner.planners.pomcp.buffers import Numbers
from fatigue_planner.planners.pomcp.search import Node


@inlined
def ucb1(node: Node, scale: float, numbers: Numbers) -> int:
    """The first action not tried yet, else the first with the best value + scale * sqrt(log N(h) / N(h, a)).

    The tables make the score of an action not tried infinite; `scale` must not be 0 (see `numbers.TINY`).
    """
    width = scale * numbers.root_log[node.visited - 1]
    best, best_score = 0, -np.inf
    for action in range(node.value.size):
        score = node.value[action] + width * numbers.inverse_root[node.tried[action]]
        if score > best_score:
            best, best_score = action, score
    return best


@inlined
def select_fixed(node: Node, numbers: Numbers) -> int:
    """UCB1 with the constant as it is."""
    return ucb1(node, numbers.exploration_constant, numbers)


@inlined
def note_nothing(_node: Node, _gained: float) -> None:
    """A fixed constant needs nothing of the returns."""

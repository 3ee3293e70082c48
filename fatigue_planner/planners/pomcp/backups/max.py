"""The max backup: POMCP-Max (paper, section III-D), which is MaxUCT (Keller & Helmert 2013) on histories."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined
from fatigue_planner.planners.pomcp.buffers import Numbers
from fatigue_planner.planners.pomcp.search import Node


@inlined
def best_value(node: Node) -> float:
    """V(h): the best of the actions tried; an action not yet tried does not count as 0."""
    best = -np.inf
    for action in range(node.value.size):
        if node.tried[action] > 0:
            best = max(best, node.value[action])
    return best


@inlined
def back_up_max(_nodes: NDArray[Any], node: Node, action: int, target: float, numbers: Numbers) -> float:
    """Q(h, a) = mean reward + gamma * mean over the visits of the successors' current V.

    V(h) = max over the actions tried of Q(h, a); of a leaf, its leaf value. N visits of value V count N V in
    the sum over the visits, so what a node passes on is by how much that has changed: with the target
    r + gamma (N V - N' V'), the mean over the targets is Q without a look at the other successors.
    """
    node.value[action] += (target - node.value[action]) * numbers.inverse[node.tried[action]]
    before, after = node.best, best_value(node)
    node.best = after
    return float(node.visited * after - (node.visited - 1) * before)

"""UCB1: which action a descent chooses in a node, with a fixed or a scaled exploration constant."""

import numpy as np

from fatigue_planner.core.jit import inlined
from fatigue_planner.planners.pomcp.buffers import TINY, SearchParameters
from fatigue_planner.planners.pomcp.search import Node


@inlined
def ucb1(node: Node, scale: float, parameters: SearchParameters) -> int:
    """The first action not tried yet, else the first with the best value + scale * sqrt(log N(h) / N(h, a)).

    The tables make the score of an action not tried infinite; `scale` must not be 0 (see `buffers.TINY`).
    """
    width = scale * parameters.root_log[node.visited - 1]
    best, best_score = 0, -np.inf
    for action in range(node.value.size):
        score = node.value[action] + width * parameters.inverse_root[node.tried[action]]
        if score > best_score:
            best, best_score = action, score
    return best


@inlined
def select_fixed(node: Node, parameters: SearchParameters) -> int:
    """UCB1 with the constant as it is (paper, section III-D)."""
    return ucb1(node, parameters.exploration_constant, parameters)


@inlined
def note_nothing(_node: Node, _discounted_return: float) -> None:
    """A fixed constant needs no record of the returns."""


@inlined
def select_scaled(node: Node, parameters: SearchParameters) -> int:
    """UCB1 with c times the standard deviation of the returns through the node, which fits any unit of reward."""
    deviation = np.sqrt(node.spread * parameters.inverse[max(node.visited - 1, 1)])
    return ucb1(node, max(parameters.exploration_constant * deviation, TINY), parameters)


@inlined
def note_spread(node: Node, discounted_return: float) -> None:
    """Welford's running mean and sum of squared deviations; visited - 1 returns have been seen."""
    difference = discounted_return - node.average
    node.average += difference / (node.visited - 1)
    node.spread += difference * (discounted_return - node.average)

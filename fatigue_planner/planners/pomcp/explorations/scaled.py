"""UCB1 whose constant is scaled by the spread of the returns seen, so that it fits any unit of reward."""

import numpy as np

from fatigue_planner.core.jit import inlined
from fatigue_planner.planners.pomcp.buffers import TINY, Numbers
from fatigue_planner.planners.pomcp.explorations.fixed import ucb1
from fatigue_planner.planners.pomcp.search import Node


@inlined
def select_scaled(node: Node, numbers: Numbers) -> int:
    """UCB1 with c times the standard deviation of the returns of the descents through the node."""
    deviation = np.sqrt(node.spread * numbers.inverse[max(node.visited - 1, 1)])
    return ucb1(node, max(numbers.exploration_constant * deviation, TINY), numbers)


@inlined
def note_spread(node: Node, gained: float) -> None:
    """Welford's running mean and sum of squared deviations; visited - 1 returns have been seen."""
    difference = gained - node.average
    node.average += difference / (node.visited - 1)
    node.spread += difference * (gained - node.average)

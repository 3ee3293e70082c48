"""UCB1 whose constant is scaled by the spread of the returns seen, so that it fits any unit of reward."""

import numpy as np

from fatigue_planner.compiled import compiled
from fatigue_planner.planners.explorations.fixed import ucb1
from fatigue_planner.planners.search.descent import Numbers
from fatigue_planner.planners.search.tree import Tree


@compiled
def select_scaled(tree: Tree, node: int, times: int, numbers: Numbers) -> int:
    """UCB1 with c times the standard deviation of the returns of the descents through the node."""
    deviation = np.sqrt(tree.spread[node] / max(times, 1))
    return int(ucb1(tree, node, times, numbers.exploration_constant * deviation, numbers))


@compiled
def note_spread(tree: Tree, node: int, gained: float) -> None:
    """Welford's running mean and sum of squared deviations; `visited` - 1 returns have been seen."""
    times = tree.visited[node] - 1
    difference = gained - tree.average[node]
    tree.average[node] += difference / times
    tree.spread[node] += difference * (gained - tree.average[node])

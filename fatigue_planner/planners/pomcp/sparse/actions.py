"""Which action a descent chooses: UCB1 among those that are legal, preferred ones with visits they begin with.

The prior is that of Silver & Veness (2010): a preferred action begins with a number of visits and a value.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined
from fatigue_planner.planners.pomcp.buffers import TINY, SearchParameters
from fatigue_planner.planners.pomcp.search import Node
from fatigue_planner.planners.pomcp.tree import Vector
from fatigue_planner.pomdp.parts import is_legal, prior

# The most visits that an action may begin with.
MOST_PRIOR_VISITS = 1000
# No action was legal.
NO_ACTION = -1


@inlined
def fixed_scale(_node: Node, parameters: SearchParameters) -> float:
    """The constant as it is."""
    return parameters.exploration_constant


@inlined
def scale_of_returns(node: Node, parameters: SearchParameters) -> float:
    """The constant times the standard deviation of the returns through the node."""
    deviation = np.sqrt(node.spread * parameters.inverse[max(node.visited - 1, 1)])
    return float(max(parameters.exploration_constant * deviation, TINY))


def exploration_scale(node: Node, parameters: SearchParameters) -> float:
    """Placeholder for one of the two."""
    raise NotImplementedError


def actions_to_consider(node: Node, wide: Any) -> float:
    """Placeholder for how many of the legal actions a node considers (see `widening`)."""
    raise NotImplementedError


def best_legal_action(
    arrays: Any, state: Vector, node: Node, allowed: NDArray[np.bool_], parameters: SearchParameters, wide: Any
) -> int:
    """Template: UCB1 (see `ucb.ucb1`) among the actions that the state permits and `allowed` (A,); or NO_ACTION."""
    width = exploration_scale(node, parameters) * parameters.root_log[node.visited - 1]
    most = actions_to_consider(node, wide)
    best, best_score, considered = NO_ACTION, -np.inf, 0
    for action in range(node.value.size):
        if not allowed[action] or not is_legal(arrays, state, action):
            continue
        considered += 1
        if considered > most and node.tried[action] == 0:
            continue
        score = node.value[action] + width * parameters.inverse_root[node.tried[action]]
        if best == NO_ACTION or score > best_score:
            best, best_score = action, score
    return best


def begin_with_prior(arrays: Any, state: Vector, node: Node) -> None:
    """Template: give the actions of a new node, reached in `state`, the visits and values that they begin with."""
    for action in range(node.value.size):
        if is_legal(arrays, state, action):
            visits, value = prior(arrays, state, action)
            if visits >= 1:
                node.tried[action] = np.uint32(min(visits, MOST_PRIOR_VISITS))
                node.value[action] = value

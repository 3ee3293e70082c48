"""Steps that a descent need not take again, because they are known to end as they did before.

From one known state, where observations reveal outcomes, a node's state is always the same. So are, for an expert
without ties, the outcome of an action and its reward, which the node behind it keeps. Only a step out of the tree is
taken, from a state that is made up for by going through all steps at once. In other problems every step is taken.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined, inlined_for_any_problem
from fatigue_planner.planners.pomcp.buffers import Workspace
from fatigue_planner.planners.pomcp.search import Node
from fatigue_planner.planners.pomcp.tree import UNVISITED, Vector
from fatigue_planner.pomdp.fatigue_pomdp import FatigueArrays, first_row
from fatigue_planner.pomdp.parts import step
from fatigue_planner.pomdp.simd import move_along


@inlined_for_any_problem
def recall_nothing(
    _arrays: Any, _nodes: NDArray[Any], _node: Node, _action: int, _workspace: Workspace, _depth: int
) -> int:
    """Every step is taken."""
    return UNVISITED


@inlined_for_any_problem
def catch_up_with_nothing(_arrays: Any, _workspace: Workspace, _begin: int, _end: int) -> None:
    """No step is left out."""


def take_any_step(
    arrays: Any, state: Vector, action: int, scratch: Vector, rng: np.random.Generator
) -> tuple[int, float, bool]:
    """Template: a step that may end otherwise the next time."""
    observation, reward = step(arrays, state, action, scratch, rng)
    return observation, reward, False


@inlined_for_any_problem
def keep_nothing(_node: Node, _reward: float, _always: bool) -> None:
    """Nodes have no place for a reward."""


@inlined
def recall_sure(
    arrays: FatigueArrays, nodes: NDArray[Any], node: Node, action: int, workspace: Workspace, depth: int
) -> int:
    """The node behind an action that always leads there; its step is written down. UNVISITED if there is none."""
    for observation in range(node.child.shape[1]):
        child = node.child[action, observation]
        if child != UNVISITED and not np.isnan(nodes[child].reward):
            workspace.rewards[depth] = nodes[child].reward
            workspace.rows[depth] = first_row(arrays, workspace.state, action) + observation
            return int(child)
    return UNVISITED


@inlined
def catch_up(arrays: FatigueArrays, workspace: Workspace, begin: int, end: int) -> None:
    """Take the steps to depths begin + 1 ... end that were only recalled."""
    move_along(arrays.gain, arrays.offset, workspace.state, workspace.rows, begin, end)


@inlined
def keep_reward(node: Node, reward: float, always: bool) -> None:
    """Keep the reward of the step to a node, or that it may be another one the next time."""
    node.reward = reward if always else np.nan

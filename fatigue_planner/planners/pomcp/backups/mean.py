"""The mean backup: a chance node's value is the mean of the returns of the descents through it (POMCP)."""

from typing import Any

from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined, inlined_for_any_problem
from fatigue_planner.planners.pomcp.buffers import Numbers, Room
from fatigue_planner.planners.pomcp.search import Node


@inlined_for_any_problem
def expect_nothing(_arrays: Any, _node: Node, _action: int, _room: Room, _certain: bool) -> None:
    """A backup by sampled rewards needs nothing beforehand."""


@inlined
def back_up_mean(_nodes: NDArray[Any], node: Node, action: int, target: float, numbers: Numbers) -> float:
    """Q(h, a) = mean of the discounted returns, which are passed on as they are."""
    node.value[action] += (target - node.value[action]) * numbers.inverse[node.tried[action]]
    return target

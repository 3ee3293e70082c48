"""The mean backup: a chance node's value is the mean of the returns of the descents through it (POMCP)."""

from typing import Any

from fatigue_planner.compiled import compiled, compiled_for_any_problem
from fatigue_planner.planners.search.tree import Tree, Vector


@compiled_for_any_problem
def expect_nothing(
    _arrays: Any,
    _tree: Tree,
    _node: int,
    _action: int,
    _state: Vector,
    _moved: Vector,
    _scratch: Vector,
    _certain: bool,
) -> None:
    """A backup by sampled rewards needs nothing beforehand."""


@compiled
def back_up_mean(tree: Tree, node: int, action: int, _reward: float, gained: float, _discount: float) -> None:
    """Q(h, a) = mean of the discounted returns."""
    tree.value[node, action] += (gained - tree.value[node, action]) / tree.tried[node, action]

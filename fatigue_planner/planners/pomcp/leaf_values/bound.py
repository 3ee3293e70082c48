"""What the problem itself can say of a state's value at once."""

from typing import Any

import numpy as np

from fatigue_planner.planners.pomcp.buffers import Numbers, Room
from fatigue_planner.planners.pomcp.tree import Vector


def bound(bound_arrays: Any, state: Vector) -> float:
    """Stands for the problem's own bound."""
    raise NotImplementedError


def problem_bound(
    _arrays: Any, bound_arrays: Any, room: Room, _numbers: Numbers, _actions: int, _rng: np.random.Generator
) -> float:
    """Template: the problem's bound of the state's value."""
    return bound(bound_arrays, room.state)

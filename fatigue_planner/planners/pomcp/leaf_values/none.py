"""No leaf value: a descent ends at the leaf (paper, section III-D)."""

from typing import Any

import numpy as np

from fatigue_planner.core.jit import inlined_for_any_problem
from fatigue_planner.planners.pomcp.buffers import Numbers, Room


@inlined_for_any_problem
def no_value(
    _arrays: Any, _bound_arrays: Any, _room: Room, _numbers: Numbers, _actions: int, _rng: np.random.Generator
) -> float:
    """0."""
    return 0.0

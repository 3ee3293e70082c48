"""No leaf value: a descent ends at the leaf (paper, section III-D)."""

from typing import Any

import numpy as np

from fatigue_planner.compiled import compiled_for_any_problem
from fatigue_planner.planners.search.descent import Numbers
from fatigue_planner.planners.search.tree import Vector


@compiled_for_any_problem
def no_value(
    _arrays: Any,
    _state: Vector,
    _moved: Vector,
    _scratch: Vector,
    _numbers: Numbers,
    _actions: int,
    _rng: np.random.Generator,
) -> float:
    """0."""
    return 0.0

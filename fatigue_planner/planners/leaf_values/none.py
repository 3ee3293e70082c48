"""No leaf value: a descent ends at the leaf (paper, section III-D)."""

from typing import Any

import numpy as np

from fatigue_planner.compiled import inlined
from fatigue_planner.planners.search.numbers import Numbers, Room


@inlined
def no_value(_arrays: Any, _room: Room, _numbers: Numbers, _actions: int, _rng: np.random.Generator) -> float:
    """0."""
    return 0.0

"""How the worker chooses a motion preference."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.compiled import compiled

Vector = NDArray[np.float64]


@compiled
def preference_probabilities(costs: Vector, expertise: float) -> Vector:
    """Eq. 4: P(u) = exp(-beta c_u) / sum over u' of exp(-beta c_u'), for costs (U,).

    Stable for every expertise beta from 0 (uniform) to infinity (the cheapest, ties shared equally):
    the smallest cost is subtracted first, so the largest exponential is 1.
    """
    lowest = costs.min()
    weights = np.empty_like(costs)
    for u in range(costs.size):
        excess = costs[u] - lowest
        weights[u] = 1.0 if excess == 0 else np.exp(-expertise * excess)
    return weights / weights.sum()

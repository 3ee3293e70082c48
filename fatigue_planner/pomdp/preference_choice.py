"""How the worker chooses a motion preference."""

import math

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.compiled import inlined

Vector = NDArray[np.float64]


@inlined
def normalise_choice(costs: Vector, expertise: float) -> None:
    """Eq. 4 in place: costs (U,) become P(u) = exp(-beta c_u) / sum over u' of exp(-beta c_u').

    Stable for every expertise beta from 0 (uniform) to infinity (the cheapest, ties shared equally):
    the smallest cost is subtracted first, so the largest exponential is 1. (math.exp is the same function compiled
    and not; numpy's may differ in the last bit.)
    """
    lowest = np.inf
    for u in range(costs.size):
        lowest = min(lowest, costs[u])
    total = 0.0
    for u in range(costs.size):
        excess = costs[u] - lowest
        costs[u] = 1.0 if excess == 0 else math.exp(-expertise * excess)
        total += costs[u]
    for u in range(costs.size):
        costs[u] /= total


def choice_probabilities(costs: Vector, expertise: float) -> Vector:
    """Eq. 4 for costs (U,); see `normalise_choice`."""
    probabilities = costs.copy()
    normalise_choice(probabilities, expertise)
    return probabilities

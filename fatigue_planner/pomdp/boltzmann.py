"""How the worker chooses a motion preference: Boltzmann's distribution of the costs (paper, Eq. 4).

Other choice models multiply every preference's Boltzmann factor by one of its own (see `choices.choice_model`).
"""

import math

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


@inlined
def relative_chance(excess: float, expertise: float) -> float:
    """exp(-beta excess): the Boltzmann factor of a preference that costs `excess` more than the cheapest.

    Stable for every expertise beta from 0 (all are equal) to infinity (only the cheapest; ties are equally likely).
    math.exp gives the same result compiled or not; numpy's may differ in the last bit.
    """
    if excess == 0 or expertise == 0:
        return 1.0
    if expertise == np.inf:
        return 0.0
    return math.exp(-expertise * excess)


@inlined
def lowest(costs: Vector) -> float:
    """The smallest of the costs (U,)."""
    found = np.inf
    for u in range(costs.size):
        found = min(costs[u], found)
    return found


@inlined
def weigh(costs: Vector, least: float, expertise: float, factors: Array, row: int) -> float:
    """Numerators of Eq. 4 in place: costs (U,), the smallest of which is `least`, become exp(-beta (c_u - least)).

    Each is multiplied by its factor in a row of `factors` (R, U), in the paper 1. Returns their sum.
    """
    total = 0.0
    for u in range(costs.size):
        costs[u] = relative_chance(costs[u] - least, expertise) * factors[row, u]
        total += costs[u]
    return total


@inlined
def normalise_choice(costs: Vector, expertise: float, factors: Array, row: int) -> None:
    """Eq. 4 in place: costs (U,) become P(u) = exp(-beta c_u) / sum over u' of exp(-beta c_u'); `factors`: `weigh`."""
    total = weigh(costs, lowest(costs), expertise, factors, row)
    for u in range(costs.size):
        costs[u] /= total

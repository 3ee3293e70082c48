"""Correction of p-values for the number of comparisons."""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def holm(p_values: Vector) -> Vector:
    """Holm's (1979) step-down correction (m,): the chance of any false rejection in the family stays below the level.

    NaN is no comparison: it stays NaN and does not count.
    """
    corrected = np.full(len(p_values), np.nan)
    there = np.flatnonzero(~np.isnan(p_values))
    order = there[np.argsort(p_values[there], kind="stable")]
    steps = np.arange(len(order), 0, -1)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(steps * p_values[order]))
    return corrected

"""How large a difference is: standardised, and as a probability."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import poch

Vector = NDArray[np.float64]


def cohen_dz(differences: Vector) -> float:
    """The mean difference in standard deviations of the differences (Cohen 1988, section 2.3.5)."""
    return float(differences.mean()) / float(differences.std(ddof=1))


def hedges_g(first: Vector, second: Vector) -> float:
    """The difference of the means in pooled standard deviations, without the bias of small samples (Hedges 1981).

    The factor is the exact one, Gamma(m/2) / (sqrt(m/2) Gamma((m-1)/2)) with m = n1 + n2 - 2.
    """
    freedom = len(first) + len(second) - 2
    pooled = ((len(first) - 1) * first.var(ddof=1) + (len(second) - 1) * second.var(ddof=1)) / freedom
    factor = float(poch((freedom - 1) / 2, 0.5)) / math.sqrt(freedom / 2)
    return factor * float(first.mean() - second.mean()) / math.sqrt(pooled)


def improvement(differences: Vector) -> float:
    """The share of worlds in which the first is better, ties half (probability of improvement, here paired)."""
    return float(np.mean(differences > 0) + np.mean(differences == 0) / 2)

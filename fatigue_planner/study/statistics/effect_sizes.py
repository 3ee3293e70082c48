"""How large a difference is (standardised, as a probability), and what a paired t-test of so many pairs can find."""

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import poch, stdtrit
from scipy.stats import nct

from fatigue_planner.experiment.statistics_settings import POWER
from fatigue_planner.study.statistics.intervals import standard_error

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
    """The proportion of worlds in which the first is better, ties half (probability of improvement, here paired)."""
    return float(np.mean(differences > 0) + np.mean(differences == 0) / 2)


def detectable_difference(differences: NDArray[np.float64], level: float) -> float:
    """The smallest true mean difference that the two-sided paired t-test finds with probability POWER, absolute.

    The spread of the differences (n,), n > 1, is taken as the true spread.
    """
    return detectable_noncentrality(len(differences), level) * standard_error(differences)


def power(noncentrality: float, n: int, level: float) -> float:
    """The probability of rejecting when the true mean is so many standard errors from 0 (noncentral t)."""
    critical = float(stdtrit(n - 1, 1 - level / 2))
    # the lower tail as the upper one of -t: the distribution function itself is NaN far out
    return float(nct.sf(critical, n - 1, noncentrality) + nct.sf(critical, n - 1, -noncentrality))


@cache
def detectable_noncentrality(n: int, level: float) -> float:
    """The noncentrality at which `power` is POWER; 0 where the test rejects as often by chance."""
    if level >= POWER:
        return 0.0
    high = 1.0
    while power(high, n, level) < POWER:
        high *= 2
    return float(brentq(lambda delta: power(delta, n, level) - POWER, 0.0, high, xtol=1e-13))

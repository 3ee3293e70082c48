"""What a paired t-test of so many pairs can find."""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import stdtrit
from scipy.stats import nct

from fatigue_planner.experiment.statistics_settings import POWER
from fatigue_planner.study.statistics.intervals import standard_error


def detectable_difference(differences: NDArray[np.float64], level: float) -> float:
    """The smallest true mean difference that the two-sided paired t-test finds with probability POWER, absolute.

    The spread of the differences (n,), n > 1, is taken for the true one.
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

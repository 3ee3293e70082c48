"""What a sample of differences, or two samples, say: intervals, hypothesis tests and effect sizes.

Each function takes samples (n,), n > 1; tests are two-sided, of samples that are not constant.
"""

import math
import warnings
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ndtri, poch, stdtr, stdtrit
from scipy.stats import bootstrap, nct, ttest_ind_from_stats

from fatigue_planner.experiment.statistics_settings import POWER
from fatigue_planner.study.statistics.pairing import ROUNDING

Vector = NDArray[np.float64]
Interval = tuple[float, float]

MAX_DRAWS = 10_000_000  # at a time, so that the memory needed stays below some 200 MB


def standard_error(values: Vector) -> float:
    """The standard error of the mean of values (n,), n > 1."""
    return float(values.std(ddof=1)) / math.sqrt(len(values))


def t_interval(values: Vector, level: float) -> Interval:
    """Student's interval of the mean of values (n,), n > 1, that misses it with probability `level`."""
    half = float(stdtrit(len(values) - 1, 1 - level / 2)) * standard_error(values)
    mean = float(values.mean())
    return mean - half, mean + half


def bca_interval(values: Vector, level: float, resamples: int, rng: np.random.Generator) -> Interval:
    """The bootstrap's interval of the mean, bias-corrected and accelerated (Efron 1987); values (n,), not constant.

    NaN where the resampled means all lie on one side of the mean.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the NaN says it
        interval = bootstrap(
            (values,),
            _mean,
            n_resamples=resamples,
            batch=max(1, MAX_DRAWS // len(values)),
            confidence_level=1 - level,
            method="BCa",
            vectorized=True,
            rng=rng,
        ).confidence_interval
    return float(interval.low), float(interval.high)


def _mean(values: Vector, axis: int = -1) -> Vector:
    return np.asarray(values.mean(axis=axis))


def wilson_interval(proportion: float, n: int, level: float) -> Interval:
    """Wilson's (1927) interval of a proportion among n.

    With ties counted half it is conservative: a tie's half varies less than a win or a loss.
    """
    z2 = float(ndtri(1 - level / 2)) ** 2
    middle = (proportion + z2 / (2 * n)) / (1 + z2 / n)
    half = math.sqrt(z2 / n * (proportion * (1 - proportion) + z2 / (4 * n))) / (1 + z2 / n)
    return max(0.0, middle - half), min(1.0, middle + half)


def student_p(first: Vector, second: Vector) -> float:
    """Student's (1908) test of two independent samples with one common variance: the paper's."""
    return _unpaired_p(first, second, common_variance=True)


def welch_p(first: Vector, second: Vector) -> float:
    """Welch's (1947) test of two independent samples, each with its own variance."""
    return _unpaired_p(first, second, common_variance=False)


def _unpaired_p(first: Vector, second: Vector, common_variance: bool) -> float:
    tested = ttest_ind_from_stats(
        float(first.mean()),
        float(first.std(ddof=1)),
        len(first),
        float(second.mean()),
        float(second.std(ddof=1)),
        len(second),
        equal_var=common_variance,
    )
    return float(tested.pvalue)


def paired_p(differences: Vector) -> float:
    """The paired t-test: Student's of the differences against 0."""
    t = float(differences.mean()) / standard_error(differences)
    return float(2 * stdtr(len(differences) - 1, -abs(t)))


def permutation_p(differences: Vector, resamples: int, rng: np.random.Generator) -> float:
    """Fisher's (1935) test by sign flips: the proportion of flips that leave the sum as far from 0 or farther.

    Up to 2^n <= resamples all flips are counted; beyond, that many random ones and the sample itself (Phipson and
    Smyth 2010). scipy.stats.permutation_test does the same for samples of pairs, but takes many times as long.
    """
    n = len(differences)
    total = float(differences.sum())
    limit = abs(total) - ROUNDING * float(np.abs(differences).sum())
    if n < resamples.bit_length():
        every = np.arange(2**n)[:, None] >> np.arange(n) & 1
        return float(np.mean(np.abs(total - 2 * _sums(every, differences)) >= limit))
    extreme, batch = 0, max(1, MAX_DRAWS // n)
    for start in range(0, resamples, batch):
        octets = rng.integers(0, 256, (min(batch, resamples - start), -(-n // 8)), dtype=np.uint8)
        flips = np.unpackbits(octets, axis=1, count=n)
        extreme += int(np.count_nonzero(np.abs(total - 2 * _sums(flips, differences)) >= limit))
    return (extreme + 1) / (resamples + 1)


def _sums(flips: NDArray[np.integer[Any]], differences: Vector) -> Vector:
    """What each row (n,) of zeros and ones picks of the differences (n,), added up.

    Not by BLAS: its threads are slower here, and wait for each other where cores are shared.
    """
    return np.asarray(np.einsum("ij,j->i", flips, differences))


def equivalence_p(differences: Vector, margin: float) -> float:
    """The equivalence test (TOST, Schuirmann 1987): two one-sided paired t-tests of |true mean| >= margin.

    Returns the larger p; if it is small, the true mean is within the margin.
    """
    t = (abs(float(differences.mean())) - margin) / standard_error(differences)
    return float(stdtr(len(differences) - 1, t))


def equivalent_within(differences: Vector, level: float) -> float:
    """The margin at which `equivalence_p` is the level: the far end of the interval that misses with 2 x level."""
    far = float(stdtrit(len(differences) - 1, 1 - level))
    return abs(float(differences.mean())) + far * standard_error(differences)


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

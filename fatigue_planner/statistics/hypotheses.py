"""Tests: Student's, Welch's and the paired t-test, sign flips, and the test of equivalence. All p two-sided but the last.

Each takes samples (n,), n > 1, that are not constant.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr, stdtrit
from scipy.stats import ttest_ind_from_stats

from fatigue_planner.statistics.intervals import MOST_DRAWS, standard_error
from fatigue_planner.statistics.pairing import ROUNDING

Vector = NDArray[np.float64]


def student_p(first: Vector, second: Vector) -> float:
    """Student's (1908) test of two independent samples with one common variance: the paper's."""
    return _unpaired_p(first, second, common_variance=True)


def welch_p(first: Vector, second: Vector) -> float:
    """Welch's (1947) test of two independent samples, each with its own variance."""
    return _unpaired_p(first, second, common_variance=False)


def _unpaired_p(first: Vector, second: Vector, common_variance: bool) -> float:
    numbers = [float(number) for one in (first, second) for number in (one.mean(), one.std(ddof=1), len(one))]
    return float(ttest_ind_from_stats(*numbers, equal_var=common_variance).pvalue)


def paired_p(differences: Vector) -> float:
    """The paired t-test: Student's of the differences against 0."""
    t = float(differences.mean()) / standard_error(differences)
    return float(2 * stdtr(len(differences) - 1, -abs(t)))


def permutation_p(differences: Vector, resamples: int, rng: np.random.Generator) -> float:
    """Fisher's (1935) test by sign flips: the share of flips that leave the sum as far from 0, or farther.

    Up to 2^n <= resamples all flips are counted; beyond, that many random ones and the sample itself (Phipson and
    Smyth 2010). scipy.stats.permutation_test does the same for samples of pairs, but takes twenty times as long.
    """
    n = len(differences)
    total = float(differences.sum())
    limit = abs(total) - ROUNDING * float(np.abs(differences).sum())
    if n < resamples.bit_length():
        flips = np.arange(2**n)[:, None] >> np.arange(n) & 1
        return float(np.mean(np.abs(total - 2 * (flips @ differences)) >= limit))
    extreme, batch = 0, max(1, MOST_DRAWS // n)
    for start in range(0, resamples, batch):
        drawn = rng.integers(0, 2, (min(batch, resamples - start), n), dtype=bool)
        extreme += int(np.count_nonzero(np.abs(total - 2 * (drawn @ differences)) >= limit))
    return (extreme + 1) / (resamples + 1)


def equivalence_p(differences: Vector, margin: float) -> float:
    """Two one-sided paired t-tests (Schuirmann 1987) of |true mean| >= margin; a small p speaks for less."""
    t = (abs(float(differences.mean())) - margin) / standard_error(differences)
    return float(stdtr(len(differences) - 1, t))


def equivalent_within(differences: Vector, level: float) -> float:
    """The margin at which `equivalence_p` is the level: the far end of the interval that misses with 2 x level."""
    far = float(stdtrit(len(differences) - 1, 1 - level))
    return abs(float(differences.mean())) + far * standard_error(differences)

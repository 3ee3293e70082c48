"""Tests of a difference (two-sided): Student's, Welch's, the paired t-test, sign flips; and the test of equivalence.

Each takes samples (n,), n > 1, that are not constant.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr, stdtrit
from scipy.stats import ttest_ind_from_stats

from fatigue_planner.study.statistics.intervals import MAX_DRAWS, standard_error
from fatigue_planner.study.statistics.pairing import ROUNDING

Vector = NDArray[np.float64]


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

"""Confidence intervals: of a mean, by Student's t and by the bootstrap, and of a proportion."""

import math
import warnings

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit
from scipy.stats import bootstrap

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

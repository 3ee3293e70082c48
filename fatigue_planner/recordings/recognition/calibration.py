"""From likelihoods to probabilities that are right as often as they say."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

Array = NDArray[np.float64]

MAX_LOG_TEMPERATURE = np.log(1000.0)
CONFIDENCE_BINS = 10  # of the calibration error (Naeini 2015, Guo 2017)


def posterior(log_likelihood: Array, temperature: Array, lapse: float) -> Array:
    """Probabilities (N, C, K) of C reactions that are equally likely before, after each of K parts.

    log_likelihood (N, C, K); temperature (K,): by what the likelihoods are flattened; lapse: how probable it is that
    they say nothing.
    """
    scaled = log_likelihood / temperature[: log_likelihood.shape[2]]
    sure = np.exp(scaled - np.logaddexp.reduce(scaled, axis=1, keepdims=True))
    return np.asarray((1 - lapse) * sure + lapse / log_likelihood.shape[1])


def fitted_temperature(held_out: list[tuple[Array, NDArray[np.int64]]]) -> Array:
    """The temperatures (K,), at least 1, under which people who were left out are predicted best.

    held_out: for every action, log-likelihoods (N, C, K) of repetitions of people the model does not know, and which
    reactions they were (N,). By maximum likelihood, each part by itself (temperature scaling, Guo 2017). Below 1 they
    would be surer than the model is: that few errors were seen is no reason.
    """
    parts = held_out[0][0].shape[2]

    def loss(log_temperature: float, part: int) -> float:
        total = 0.0
        for log_likelihood, truth in held_out:
            scaled = log_likelihood[:, :, part] * np.exp(-log_temperature)
            total -= float((scaled[np.arange(len(truth)), truth] - np.logaddexp.reduce(scaled, axis=1)).sum())
        return total

    found = [
        minimize_scalar(loss, bounds=(0.0, MAX_LOG_TEMPERATURE), args=(part,), method="bounded").x
        for part in range(parts)
    ]
    return np.exp(np.array(found))


def calibration_error(probability: Array, truth: NDArray[np.int64]) -> float:
    """Expected calibration error: how far the probability of what is recognised is from how often it is right.

    probability (N, C), truth (N,). Mean over bins of equal width, weighted by how many fall into each.
    """
    confidence = probability.max(axis=1)
    right = probability.argmax(axis=1) == truth
    of_bin = np.minimum((confidence * CONFIDENCE_BINS).astype(int), CONFIDENCE_BINS - 1)
    gaps = np.bincount(of_bin, right - confidence, CONFIDENCE_BINS)
    return float(np.abs(gaps).sum() / len(truth))

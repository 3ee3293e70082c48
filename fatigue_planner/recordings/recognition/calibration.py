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
    return float(_error(probability.max(axis=1), probability.argmax(axis=1) == truth))


def reliability(confidence: Array, right: NDArray[np.bool_]) -> list[tuple[int, float, float]]:
    """For every bin of `calibration_error` that is not empty: how many, their mean probability, the share right.

    confidence (N,): how probable was what was recognised; right (N,): whether it was so.
    """
    of_bin = _bins(confidence)
    return [
        (int((of_bin == one).sum()), float(confidence[of_bin == one].mean()), float(right[of_bin == one].mean()))
        for one in np.unique(of_bin)
    ]


def chance_errors(probability: Array, blocks: NDArray[np.int64], rng: np.random.Generator, draws: int) -> Array:
    """Calibration errors (draws,) that a recogniser whose probabilities are true shows on as many repetitions.

    probability (N, C); blocks (N,): repetitions of the same number are right or wrong together, as those of one person
    are (consistency resampling, Broecker and Smith 2007, by blocks).
    """
    confidence = probability.max(axis=1)
    drawn = rng.random((draws, blocks.max() + 1))
    return np.array([_error(confidence, one[blocks] < confidence) for one in drawn])


def blocks_of(people: NDArray[np.str_], reactions: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Numbers (N,) of blocks of up to `size` repetitions of one person's reaction."""
    _, whose = np.unique(people, return_inverse=True)
    of_reaction = whose * (reactions.max() + 1) + reactions
    found, last = np.empty(len(people), np.int64), 0
    for one in np.unique(of_reaction):
        own = np.flatnonzero(of_reaction == one)
        found[own] = last + np.arange(len(own)) // size
        last = int(found[own[-1]]) + 1
    return found


def _error(confidence: Array, right: NDArray[np.bool_]) -> float:
    gaps = np.bincount(_bins(confidence), right - confidence, CONFIDENCE_BINS)
    return float(np.abs(gaps).sum() / len(right))


def _bins(confidence: Array) -> NDArray[np.int64]:
    return np.minimum((confidence * CONFIDENCE_BINS).astype(np.int64), CONFIDENCE_BINS - 1)

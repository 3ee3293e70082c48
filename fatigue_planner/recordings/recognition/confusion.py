"""How often a reaction is taken for another: confusion matrices with intervals, and reactions that are one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.stats import beta

from fatigue_planner.core.settings import MAX_NAME_LENGTH

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

PRIOR = 0.5  # of every entry of a row (Jeffreys' Dirichlet prior)
LEVEL = 0.95


@dataclass(frozen=True)
class Confusion:
    """How the reactions to an action were recognised.

    counts (C, O): repetitions of each preference by what they were recognised as; effective (C,): how many independent
    ones they are worth, as those of one person resemble each other.
    """

    preferences: tuple[str, ...]
    recognised: tuple[str, ...]
    counts: Counts
    effective: Array

    def _posterior(self) -> Array:
        """The parameters (C, O) of the Dirichlet distribution of every row."""
        total = self.counts.sum(axis=1, keepdims=True)
        return np.asarray(self.counts / total * self.effective[:, None] + PRIOR)

    def probability(self) -> Array:
        """P(recognised as o | preference u), (C, O): the mean after the counts, which is never 0."""
        alpha = self._posterior()
        return np.asarray(alpha / alpha.sum(axis=1, keepdims=True))

    def interval(self) -> tuple[Array, Array]:
        """From where to where the probabilities (C, O) are with 95 % probability, each by itself."""
        alpha = self._posterior()
        rest = alpha.sum(axis=1, keepdims=True) - alpha
        if alpha.shape[1] == 1:
            return np.ones_like(alpha), np.ones_like(alpha)
        tail = (1 - LEVEL) / 2
        return np.asarray(beta.ppf(tail, alpha, rest)), np.asarray(beta.ppf(1 - tail, alpha, rest))

    def plain(self) -> dict[str, dict[str, float]]:
        """The matrix as `recognition_by_action` of an experiment has it for one action; to 1e-4."""
        rounded = np.round(self.probability(), 4)
        rounded[np.arange(len(rounded)), rounded.argmax(axis=1)] += 1 - rounded.sum(axis=1)
        rows = zip(self.preferences, np.round(rounded, 4).tolist(), strict=True)
        return {name: dict(zip(self.recognised, row, strict=True)) for name, row in rows}


def told_apart(log_likelihood: Array, truth: NDArray[np.int64]) -> Array:
    """How many of two equally likely reactions are told apart, (C, C), by log-likelihoods (N, C) of what they were."""
    n = log_likelihood.shape[1]
    found = np.ones((n, n))
    for one in range(n):
        for other in range(one):
            ahead = log_likelihood[:, one] - log_likelihood[:, other]
            right = (np.mean(ahead[truth == one] > 0) + np.mean(ahead[truth == other] < 0)) / 2
            found[one, other] = found[other, one] = right
    return found


def groups_of(apart: Array, told_apart_from: float) -> NDArray[np.int64]:
    """To which reaction of the robot's each belongs, (C,): those not told apart are one, and chains of them."""
    labels = connected_components(apart < told_apart_from, directed=False)[1]
    return np.asarray(labels, np.int64)


def merged(log_likelihood: Array, groups: NDArray[np.int64]) -> Array:
    """Log-likelihoods (N, C, ...) that are the same for all reactions that are one: the mean of their likelihoods."""
    found = np.empty_like(log_likelihood)
    for group in range(groups.max() + 1):
        own = groups == group
        found[:, own] = np.logaddexp.reduce(log_likelihood[:, own], axis=1, keepdims=True) - np.log(own.sum())
    return found


def group_names(preferences: tuple[str, ...], groups: NDArray[np.int64]) -> tuple[str, ...]:
    """What the robot calls them: the names of a group joined by `_or_` or, where that is too long, its number."""
    names = []
    for group in range(groups.max() + 1):
        joined = "_or_".join(name for name, own in zip(preferences, groups, strict=True) if own == group)
        names.append(joined if len(joined) <= MAX_NAME_LENGTH else f"group_{group + 1}")
    return tuple(names)


def design_effect(right: NDArray[np.bool_], reactions: NDArray[np.int64], people: NDArray[np.int64]) -> float:
    """How many times the variance of the share of right ones is what it were if all were independent, at least 1.

    right, reactions, people (N,): of every repetition. By the scatter between the shares of the people who show the
    same reaction (Rao and Scott 1992), pooled over the reactions. Where no error was made, nothing tells: then each
    person counts as one repetition.
    """
    scatter = expected = 0.0
    sizes = []
    for reaction in np.unique(reactions):
        own = reactions == reaction
        share = right[own].mean()
        whose = np.unique(people[own], return_inverse=True)[1]
        size = np.bincount(whose)
        sizes += size.tolist()
        sums = np.bincount(whose, right[own])
        scatter += ((sums - share * size) ** 2).sum() * len(size) / max(len(size) - 1, 1)
        expected += share * (1 - share) * size.sum()
    largest = float(np.mean(sizes))
    return float(np.clip(scatter / expected, 1.0, largest)) if expected > 0 else largest

"""How the reactions to one action are distributed: a Gaussian for every preference, with one covariance for all.

The angles of a reaction are independent between degrees of freedom and correlated over the parts of a cycle: the
covariance is the product of a variance for each degree of freedom and one matrix over the parts (a matrix normal
distribution). With few people there is no more to be had: their offsets are as many draws as there are people.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import brentq
from scipy.special import digamma, polygamma

from fatigue_planner.recordings.recognition.repetitions import N_PARTS, WORK, Repetitions

Array = NDArray[np.float64]

MIN_PEOPLE = 2  # who show a reaction: of one alone nothing says how others differ
ANGLE_ERROR_DEG = 0.5  # no angle is known better, however little it varies; assumed
SLIGHT = 1e-8  # excess scatter that is none
ROUNDS = 5  # of the alternating estimate, which changes by less than 1 % after three


@dataclass(frozen=True)
class ActionModel:
    """The distributions of the reactions to an action, as far as they were measured.

    preferences: C names; joints (J,): which degrees of freedom were measured in all repetitions; mean_deg
    (C, N_PARTS, J); variance_deg2 (J,); correlation (N_PARTS, N_PARTS): its diagonal has the mean 1; people (C,): how
    many showed the reaction.
    """

    preferences: tuple[str, ...]
    joints: NDArray[np.int64]
    mean_deg: Array
    variance_deg2: Array
    correlation: Array
    people: NDArray[np.int64]

    @classmethod
    def fit(cls, repetitions: Repetitions, preferences: tuple[str, ...]) -> Self:
        """The model of an action's repetitions, in which at least `MIN_PEOPLE` show every one of the preferences.

        Every person counts the same, however often he or she repeats.
        """
        joints = np.flatnonzero(np.isfinite(repetitions.angles_deg).all(axis=(0, 1)))
        angles = repetitions.angles_deg[:, :, joints]
        means, residuals, weights, people = [], [], [], []
        for preference in preferences:
            own = repetitions.preferences == preference
            names, whose = np.unique(repetitions.people[own], return_inverse=True)
            of_people = np.array([angles[own][whose == one].mean(axis=0) for one in range(len(names))])
            means.append(of_people.mean(axis=0))
            # the mean follows the people it is made of: what is left of their differences is too small by this
            lost = len(names) / (len(names) - 1)
            residuals.append((angles[own] - means[-1]) * np.sqrt(lost))
            weights.append(1 / (np.bincount(whose)[whose] * len(names) * len(preferences)))
            people.append(len(names))
        variance, correlation = _covariance(
            np.concatenate(residuals), np.concatenate(weights), len(set(repetitions.people)) - 1
        )
        return cls(preferences, joints, np.array(means), variance, correlation, np.array(people))

    def log_likelihood(self, angles_deg: Array) -> Array:
        """ln p(what is seen until the end of part k | preference) for motions (N, K, J all): (N, C, K).

        Up to a constant that is the same for all preferences. A degree of freedom of which a part was not seen says
        nothing from then on.
        """
        seen = angles_deg[:, :, self.joints]
        parts = seen.shape[1]
        known = np.logical_and.accumulate(np.isfinite(seen), axis=1)
        # the first rows of a Cholesky factor are the factor of the first rows: each part adds what is new in it
        whitening = _whitening(self.correlation)[:parts, :parts]
        found = np.empty((len(seen), len(self.preferences), parts))
        for one, mean in enumerate(self.mean_deg):
            apart = np.where(known, seen - mean[:parts], 0.0)
            # not by a linear algebra library, whose threads would cost more than they save
            new = np.einsum("pq,nqj->npj", whitening, apart)
            spread = 1 + 1 / self.people[one]  # the mean, too, is known from some people only
            squares = (np.where(known, new**2, 0.0) / self.variance_deg2).sum(axis=2) / spread
            found[:, one] = -0.5 * np.cumsum(squares + np.log(spread) * known.sum(axis=2), axis=1)
        return found

    def difference_deg(self) -> Array:
        """How far the preferences' mean angles are apart, (C, C): root mean square over work and degrees of freedom."""
        work = self.mean_deg[:, WORK]
        return np.asarray(np.sqrt(((work[:, None] - work[None]) ** 2).mean(axis=(2, 3))))


def _covariance(residuals: Array, weights: Array, freedom: int) -> tuple[Array, Array]:
    """Variances (J,) and the matrix over the parts (P, P) of weighted residuals (N, P, J), in turn from each other."""
    weighted = residuals * np.sqrt(weights)[:, None, None]
    of_joints = np.einsum("npj,nqj->jpq", weighted, weighted)
    correlation = np.eye(N_PARTS)
    for _ in range(ROUNDS):
        white = _whitening(correlation)
        variance = np.einsum("pq,jpq->j", white.T @ white, of_joints) / N_PARTS
        variance = moderated(np.maximum(variance, ANGLE_ERROR_DEG**2), freedom)
        correlation = (of_joints / variance[:, None, None]).mean(axis=0)
        size = np.trace(correlation) / N_PARTS
        if size > 0:
            correlation, variance = correlation / size, variance * size
        correlation += np.eye(N_PARTS) * ANGLE_ERROR_DEG**2 / variance.mean()
    return variance, correlation


def _whitening(correlation: Array) -> Array:
    """The lower triangle (P, P) that makes parts of this covariance independent, of variance 1."""
    return np.asarray(solve_triangular(np.linalg.cholesky(correlation), np.eye(len(correlation)), lower=True))


def moderated(variance: Array, freedom: int) -> Array:
    """Variances (J,) drawn to their common value by as much as their scatter is chance (Smyth 2004, limma).

    freedom: degrees of freedom of each of them. The variances are taken for draws from a scaled inverse chi-squared
    distribution, whose degrees of freedom follow from the scatter of their logarithms.
    """
    half = freedom / 2
    logs = np.log(variance) - digamma(half) + np.log(half)
    excess = float(np.var(logs, ddof=1) - polygamma(1, half)) if len(variance) > 1 else 0.0
    if excess <= SLIGHT:
        return np.full(len(variance), np.exp(logs.mean()))
    prior_half = np.exp(brentq(lambda log: float(polygamma(1, np.exp(log))) - excess, np.log(1e-6), np.log(1e9)))
    common = np.exp(logs.mean() + digamma(prior_half) - np.log(prior_half))
    return np.asarray((prior_half * common + half * variance) / (prior_half + half))

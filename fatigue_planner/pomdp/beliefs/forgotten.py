"""What cycles that nobody remembers one by one have told about a worker: their log-likelihood as a quadratic.

Over the workers that are still likely, the log-likelihood of a hundred cycles is nearly a quadratic in the normal
scores of their quantiles, the more so the more is known (Bernstein and von Mises). So a quadratic is fitted to it, at
workers drawn from the belief, for each combination of the values of discrete distributions; the quadratics of all that
was forgotten add up. Their log-likelihoods come from small particle filters: the outcomes that a particle holds true
have been selected by the evidence, which would count twice.

Limits. Experts whose choices are certain allow only some rates: that is no quadratic, and such limits are forgotten.
Where only a product of two rates can be learnt, likely workers lie along a curve, and the sum of many quadratics is
more certain than it should be: so only the last MAX_BLOCKS count in full.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.pomdp.hidden_worker import Choice, WorkerPrior

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# Quantiles are kept off 0 and 1, whose normal scores are infinite.
MIN_QUANTILE = 1e-12
# Workers per coefficient of a quadratic, and the fewest with which one is fitted.
PER_COEFFICIENT, MIN_PER_COEFFICIENT = 4, 2
# More blocks are not known at a time: a shift of 12 hours has 27 of 100 cycles.
MAX_BLOCKS = 30
# Standard deviation of these workers, as a fraction of that which one block alone would leave, and at most in scores.
WIDTH, MAX_WIDTH = 0.5, 0.5
# The most workers at which a log-likelihood is computed.
MAX_DESIGN = 120


@dataclass(frozen=True)
class Quadratic:
    """constant + linear x + x' square x in normal scores x (d,); centre (d,): where the particles were."""

    constant: float
    linear: Vector
    square: Array
    centre: Vector

    @staticmethod
    def flat(constant: float, size: int) -> "Quadratic":
        """The same everywhere."""
        return Quadratic(constant, np.zeros(size), np.zeros((size, size)), np.zeros(size))

    def at(self, scores: Array) -> Vector:
        """The values (n,) at scores (n, d).

        Along axes where it is convex, the tangent at the centre: it must not grow where no particle was.
        """
        away, centre = scores - self.centre, self.centre
        bends, axes = np.linalg.eigh(self.square)
        there = self.constant + self.linear @ centre + centre @ self.square @ centre
        tangent = away @ (self.linear + 2 * self.square @ centre)
        return np.asarray(there + tangent + np.square(away @ axes) @ np.minimum(bends, 0.0))

    def plus(self, later: "Quadratic", share: float) -> "Quadratic":
        """The sum of a share of it and a later one, about the later centre."""
        return Quadratic(
            share * self.constant + later.constant,
            share * self.linear + later.linear,
            share * self.square + later.square,
            later.centre,
        )


# The values of a worker's discrete parameters, 0 for others.
Combination = tuple[float, ...]


@dataclass(frozen=True)
class Forgotten:
    """Quadratics by combination, of some blocks of cycles; least: the log-likelihood where none was fitted."""

    quadratics: Mapping[Combination, Quadratic]
    least: float
    blocks: int = 1

    def log_likelihood(self, prior: WorkerPrior, quantiles: Array) -> Vector:
        """The log-likelihood (n,) of what is forgotten for workers at quantiles (n, 3)."""
        scores, discrete = coordinates(prior, quantiles)
        found = np.full(len(quantiles), self.least)
        for combination, quadratic in self.quadratics.items():
            mine = (discrete == combination).all(axis=1)
            found[mine] = quadratic.at(scores[mine])
        return found

    def and_then(self, later: "Forgotten") -> "Forgotten":
        """What both tell together. Of more than MAX_BLOCKS, the old ones count less with each that comes."""
        share = min(1.0, MAX_BLOCKS / (self.blocks + later.blocks))
        size = next(iter(later.quadratics.values())).centre.size
        before, after = Quadratic.flat(self.least, size), Quadratic.flat(later.least, size)
        sums = {
            combination: replace(
                self.quadratics.get(combination, before).plus(later.quadratics.get(combination, after), share),
                centre=(later.quadratics.get(combination) or self.quadratics[combination]).centre,
            )
            for combination in {**self.quadratics, **later.quadratics}
        }
        return Forgotten(sums, share * self.least + later.least, min(MAX_BLOCKS, self.blocks + later.blocks))


def coordinates(prior: WorkerPrior, quantiles: Array) -> tuple[Array, Array]:
    """The normal scores (n, d) of continuous parameters that are hidden, and the values (n, 3) of discrete ones."""
    from scipy.special import ndtri  # noqa: PLC0415 - takes 0.2 s

    chosen = np.array([isinstance(distribution, Choice) for distribution in prior.distributions])
    discrete = np.where(chosen, np.array(prior.at(quantiles)).T, 0.0)
    return ndtri(np.clip(quantiles[:, ~chosen], MIN_QUANTILE, 1 - MIN_QUANTILE)), discrete


def design(prior: WorkerPrior, quantiles: Array, weights: Vector, blocks: int, rng: np.random.Generator) -> Array:
    """The quantiles (m, 3) of workers, enough for a quadratic in every combination of discrete values of a belief.

    They are drawn from the belief and spread as far as one of the `blocks` that it knows could tell them apart: the
    more is known, the nearer to each other are all likely workers, and the more would the noise of filters count.
    """
    from scipy.special import ndtr  # noqa: PLC0415 - takes 0.2 s

    scores, discrete = coordinates(prior, quantiles)
    combinations, number = np.unique(discrete, axis=0, return_inverse=True)
    size = scores.shape[1]
    enough = PER_COEFFICIENT * (size + 1) * (size + 2) // 2 if size else 1
    each = max(1, min(enough, MAX_DESIGN // len(combinations)))
    continuous = [i for i, distribution in enumerate(prior.distributions) if not isinstance(distribution, Choice)]
    found = []
    for i in range(len(combinations)):
        mine = np.flatnonzero((number.ravel() == i) & (weights > 0))
        if mine.size > 0:
            ends = np.cumsum(weights[mine])
            places = np.searchsorted(ends, (np.arange(each) + rng.random()) / each * ends[-1], side="right")
            chosen = np.unique(mine[np.minimum(places, mine.size - 1)])
            workers = quantiles[chosen]
            workers[:, continuous] = ndtr(spread_out(scores[chosen], WIDTH * np.sqrt(blocks)))
            found.append(workers)
    return np.concatenate(found)


def spread_out(scores: Array, factor: float) -> Array:
    """Scores (n, d) whose deviations along each principal axis are `factor` times as large, but not above MAX_WIDTH."""
    away = scores - scores.mean(axis=0)
    variance, axes = np.linalg.eigh(away.T @ away / len(scores))
    width = np.sqrt(np.maximum(variance, 0.0))
    wanted = np.maximum(width, np.minimum(factor * width, MAX_WIDTH))
    stretch = np.where(width > 0, wanted / np.where(width > 0, width, 1.0), 1.0)
    return np.asarray(scores.mean(axis=0) + (away @ axes * stretch) @ axes.T)


def fitted(prior: WorkerPrior, quantiles: Array, values: Vector) -> Forgotten:
    """The quadratics nearest to `values` (n,), log-likelihoods of workers at quantiles (n, 3)."""
    scores, discrete = coordinates(prior, quantiles)
    combinations, number = np.unique(discrete, axis=0, return_inverse=True)
    quadratics = {}
    for i, combination in enumerate(combinations.tolist()):
        mine = number.ravel() == i
        quadratics[tuple(combination)] = nearest_quadratic(scores[mine], values[mine])
    return Forgotten(quadratics, float(values.min()))


def nearest_quadratic(scores: Array, values: Vector) -> Quadratic:
    """The quadratic nearest to values (n,) at scores (n, d), by least squares; with few of them, a plane or a mean."""
    count, size = scores.shape
    centre, spread = scores.mean(axis=0), scores.std(axis=0)
    scale = np.where(spread > 0, spread, 1.0)
    unit = (scores - centre) / scale
    first, second = np.triu_indices(size)
    terms = np.column_stack([np.ones(count), unit, unit[:, first] * unit[:, second]])
    orders = [used for used in (terms.shape[1], 1 + size) if count >= MIN_PER_COEFFICIENT * used]
    used = orders[0] if orders else 1
    found = np.zeros(terms.shape[1])
    found[:used] = np.linalg.lstsq(terms[:, :used], values)[0]
    square = np.zeros((size, size))
    square[first, second] = found[1 + size :]
    square = (square + square.T) / 2 / np.outer(scale, scale)
    slope = found[1 : 1 + size] / scale
    constant = found[0] - slope @ centre + centre @ square @ centre
    return Quadratic(float(constant), slope - 2 * square @ centre, square, centre)

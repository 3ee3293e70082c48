"""The most likely beta, offsets and inertia, their profile-likelihood intervals, and which of them are worth having."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.recordings.learning.bias import Observed, step
from fatigue_planner.recordings.learning.likelihood import (
    Choices,
    Confusion,
    Smoothed,
    confusion_terms,
    smoothed,
    softmax,
)

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# 95 % of chi-squared with one degree of freedom.
CRITICAL = 3.841458820694124
# Utilities further apart than this nobody can tell from a certain choice: beta then counts as infinite.
MOST_UTILITY = 30.0
MOST_LOG_ODDS = 15.0
# Log-likelihoods that differ by less are equal: beta is then as large as it can be.
FLAT = 1e-3
# Ends of intervals are found to this, in usual utilities.
PRECISION = 5e-3
# Starting points for beta, in utilities between reactions whose costs differ as usual.
STARTS = (0.3, 2.0)
# Scoring without bias ends where nothing moves by more, after so many steps at most; no number moves further in one.
STILL, MAX_STEPS, FURTHEST = 1e-6, 200, 1.0
# Which parameters each model has besides beta.
MODELS: dict[str, tuple[bool, bool]] = {
    "boltzmann": (False, False), "offset": (True, False), "inertia": (True, True),
}  # fmt: skip


@dataclass(frozen=True)
class Interval:
    """An estimate without first-order bias (`bias`), and the 95 % profile-likelihood interval.

    Infinite where the data set no limit.
    """

    estimate: float
    low: float
    high: float


@dataclass(frozen=True)
class Fit:
    """The most likely parameters: beta in 1 / cost, offsets (U,) against the first preference's, inertia.

    chances (n, U): of the reactions given all that was seen; parameters: how many were free.
    """

    beta: float
    offsets: Vector
    inertia: float
    log_likelihood: float
    parameters: int
    chances: Array
    point: Vector

    @property
    def aic(self) -> float:
        """Akaike's information criterion."""
        return 2 * self.parameters - 2 * self.log_likelihood


class Estimator:
    """Fits of one worker's cycles. The first numbers of a point: beta in usual cost differences, offsets, inertia."""

    def __init__(self, choices: Choices, confusion: Confusion) -> None:
        self.choices, self.confusion = choices, confusion
        self.preferences = int(choices.costs.shape[1])
        relative = choices.costs - choices.costs.mean(axis=1, keepdims=True)
        self.scale = float(np.sqrt(np.square(relative).mean()))
        if self.scale == 0:
            raise SelectionError("in no cycle do the reactions' costs differ: nothing can be learnt of beta.")
        self.relative = relative / self.scale
        self.most_beta = MOST_UTILITY

    @cached_property
    def _logits(self) -> Vector:
        return np.log(self.confusion.chances).ravel() if self.confusion.labelled is not None else np.zeros(0)

    @property
    def leading(self) -> int:
        """How many numbers of a point are no logits of the confusion: beta, U - 1 offsets, inertia."""
        return self.preferences + 1

    def at(self, point: Vector) -> tuple[float, Vector, Smoothed]:
        """The log-likelihood of a point, its gradient, and the reactions."""
        size = self.preferences
        beta, offsets, inertia = point[0], np.append(0.0, point[1:size]), float(point[size])
        logits = point[size + 1 :].reshape(self.confusion.chances.shape) if self._logits.size else None
        matrix = self.confusion.chances if logits is None else softmax(logits)
        found = smoothed(offsets - beta * self.relative, inertia, self.choices, matrix)
        value = found.log_likelihood
        gradient = [
            np.array([-(found.residual * self.relative).sum()]), found.residual.sum(axis=0)[1:], np.array([found.stay]),
        ]  # fmt: skip
        if logits is not None:
            assert self.confusion.labelled is not None
            labelled, by_logits = confusion_terms(logits, self.choices, found.chances, self.confusion.labelled)
            value += labelled
            gradient.append(by_logits.ravel())
        return value, np.concatenate(gradient), found

    def fit(self, model: str = "inertia", fixed: Mapping[int, float] | None = None, start: Vector | None = None) -> Fit:
        """The most likely point of a model, with some of the leading numbers fixed."""
        from scipy.optimize import minimize  # noqa: PLC0415 - takes 0.2 s

        has_offsets, has_inertia = MODELS[model]
        held = dict(fixed or {})
        if not has_offsets:
            held |= dict.fromkeys(range(1, self.preferences), 0.0)
        if not has_inertia:
            held[self.preferences] = 0.0
        free = np.array([i for i in range(self.leading + self._logits.size) if i not in held])
        bounds = np.array(
            [(0.0, self.most_beta)] + [(-MOST_LOG_ODDS, MOST_LOG_ODDS)] * (self.leading - 1 + self._logits.size)
        )
        begins = [start] if start is not None else [
            np.concatenate([[beta], np.zeros(self.leading - 1), self._logits]) for beta in STARTS
        ]  # fmt: skip
        best: tuple[float, Vector] | None = None
        for begin in begins:
            point = np.clip(begin, *bounds.T)
            for index, value in held.items():
                point[index] = value

            def loss(values: Vector, point: Vector = point) -> tuple[float, Vector]:
                moved = point.copy()
                moved[free] = values
                value, gradient, _ = self.at(moved)
                return -value, -gradient[free]

            if free.size:
                done = minimize(loss, point[free], jac=True, method="L-BFGS-B", bounds=bounds[free],
                                options={"ftol": 1e-11, "gtol": 1e-5})  # fmt: skip
                point[free] = done.x
            value = self.at(point)[0]
            if best is None or value > best[0] + 1e-9:
                best = value, point
        assert best is not None
        value, point = best
        certain = point.copy()
        certain[0] = self.most_beta
        beta = math.inf if 0 not in held and self.at(certain)[0] >= value - FLAT else point[0] / self.scale
        return Fit(
            float(beta),
            np.append(0.0, point[1 : self.preferences]),
            float(point[self.preferences]),
            value,
            sum(i < self.leading for i in free.tolist()),
            self.at(point)[2].chances,
            point,
        )

    def without_bias(self, fit: Fit, model: str) -> Vector:
        """The point of a model's fit without first-order bias; the fit's own where it is at a limit or none is found.

        At a limit (beta 0 or endless, an offset or inertia endless) maximum likelihood has no such expansion.
        """
        most = np.array([self.most_beta] + [MOST_LOG_ODDS] * (self.leading - 1))
        numbers = fit.point[: self.leading]
        if math.isinf(fit.beta) or numbers[0] <= 0 or (np.abs(numbers) >= most).any():
            return fit.point
        has_offsets, has_inertia = MODELS[model]
        held = set() if has_offsets else set(range(1, self.preferences))
        held |= set() if has_inertia else {self.preferences}
        outcomes = self.confusion.chances.shape[-1]
        held |= set(range(self.leading + outcomes - 1, self.leading + self._logits.size, outcomes))
        free = np.array([i for i in range(fit.point.size) if i not in held])
        observed = Observed(self.relative, self.choices, self.confusion.chances, self.confusion.labelled)
        point, before, share = fit.point.copy(), np.zeros(free.size), 1.0
        for _ in range(MAX_STEPS):
            _, score, found = self.at(point)
            move = step(point, score, found, observed, free)
            if move is None:
                return fit.point
            if move @ before < 0:  # it went too far
                share /= 2
            point[free] += share * move * min(1.0, FURTHEST / max(np.abs(move).max(), STILL))
            if np.abs(move).max() < STILL:
                inside = point[0] >= 0 and (np.abs(point[: self.leading]) < most).all()
                return point if inside else fit.point
            before = move
        return fit.point

    def interval(self, fit: Fit, model: str, index: int) -> Interval:
        """The estimate and interval of a leading number of a model's fit: 0 is beta, then offsets, then inertia."""
        lowest, highest = (0.0, self.most_beta) if index == 0 else (-MOST_LOG_ODDS, MOST_LOG_ODDS)
        ends = [self._end(fit, model, index, limit) for limit in (lowest, highest)]
        unit = self.scale if index == 0 else 1.0
        estimate = float(self.without_bias(fit, model)[index]) / unit
        if index == 0 and math.isinf(fit.beta):
            estimate = math.inf
        if index != 0 and abs(estimate) >= MOST_LOG_ODDS:
            estimate = math.copysign(math.inf, estimate)
        low, high = ends[0] / unit, ends[1] / unit
        if index != 0 and ends[0] <= lowest:
            low = -math.inf
        return Interval(estimate, low, math.inf if ends[1] >= highest else high)

    def _end(self, fit: Fit, model: str, index: int, limit: float) -> float:
        """Where twice the log-likelihood has fallen by CRITICAL, between the estimate and a limit."""
        nearest = fit.point

        def excess(value: float, start: Vector) -> tuple[float, Vector]:
            there = self.fit(model, {index: value}, start)
            return 2 * (fit.log_likelihood - there.log_likelihood) - CRITICAL, there.point

        inner, below = float(fit.point[index]), -CRITICAL
        step = 0.25 if limit > inner else -0.25
        while True:
            if inner == limit:
                return limit
            outer = min(inner + step, limit) if step > 0 else max(inner + step, limit)
            above, point = excess(outer, nearest)
            if above > 0:
                break
            inner, below, nearest, step = outer, above, point, 2 * step
        while abs(outer - inner) > PRECISION:  # regula falsi, kept off the ends
            share = min(max(below / (below - above), 0.1), 0.9)
            middle = inner + share * (outer - inner)
            found, point = excess(middle, nearest)
            if found > 0:
                outer, above = middle, found
            else:
                inner, below, nearest = middle, found, point
        return inner

"""The particle filter, for beliefs that no finite set can represent.

Resampling leads to particle deprivation, the loss of distinct particles. So particles are resampled only when few of
them carry the weight, and a belief in a hidden worker moves them afterwards (resample-move, see `hidden_worker`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fatigue_planner.core.jit import specialised
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.beliefs.history import MIN_PROBABILITY, History
from fatigue_planner.pomdp.fatigue_pomdp import recognition_of
from fatigue_planner.pomdp.problem import (
    Observation,
    Pomdp,
    Vector,
    advance,
    draw,
    observation_probability,
    outcome_probabilities,
)
from fatigue_planner.pomdp.timing import AS_PLANNED, Pace

# Resample where the effective sample size is below this fraction of the particles (the usual choice).
MIN_EFFECTIVE_FRACTION = 0.5


@dataclass(frozen=True)
class ParticleBelief(Belief):
    """Particles with log weights (n,), the largest 0; `weights` are their normalised exponentials.

    As the likelihoods are known, outcomes are drawn from P(u | s, a, o) and particles weighted by
    P(o | s, a) = sum over u of P(o | s', a, u) P(u | s, a): no particle contradicts the observation.

    history: recorded where `rejuvenated` needs it.

    >>> from tiger import PROBLEM  # examples/tiger.py
    >>> fp.ParticleBelief.begin(PROBLEM, np.array([[0.0], [0.0], [1.0]])).effective_size()
    3.0
    """

    log_weights: Vector = field(kw_only=True)
    history: History | None = field(default=None, kw_only=True)

    @staticmethod
    def begin(model: Pomdp, states: Array) -> "ParticleBelief":
        """Equally likely states (n, L)."""
        count = len(states)
        return ParticleBelief(model, states, np.full(count, 1 / count), log_weights=np.zeros(count))

    def effective_size(self) -> float:
        """Kong's effective sample size, 1 / sum of the squared weights."""
        return float(1 / np.square(self.weights).sum())

    def update(self, action: int, observation: Observation, rng: np.random.Generator) -> "ParticleBelief":
        """See Belief.update; an impossible observation is treated as by the exact belief."""
        self.model.check(action, observation)
        permitting = self.permitting(action)
        if permitting is not self:
            return permitting.update(action, observation, rng)
        self.model.check_again(self.states, action)
        return self._moved(self.model.belief_parts, self.model.arrays, action, observation, rng)

    def weigh(
        self, action: int, likelihood: ArrayLike, rng: np.random.Generator, *, duration_s: float | None = None
    ) -> "ParticleBelief":
        """See Belief.weigh."""
        model = self.model
        likelihood, pace = model.check_likelihood(action, likelihood), model.pace(duration_s)
        permitting = self.permitting(action)
        model.check_again(permitting.states, action)
        arrays = model.evidence_arrays(pace.share)
        return permitting._moved(model.evidence_parts, arrays, action, likelihood, rng, pace)

    def rest(self, seconds: float) -> Self:
        """See Belief.rest."""
        states = self.model.rested(self.states, seconds)
        return replace(self, states=states, history=self.history and self.history.resting(seconds))

    def warm_up(self) -> None:
        """See Belief.warm_up."""
        rng = np.random.default_rng(0)
        self.weigh(0, np.ones(len(self.model.outcomes)), rng).resampled(rng)

    def _moved(
        self,
        parts: Mapping[str, Any],
        arrays: Any,
        action: int,
        evidence: Any,
        rng: np.random.Generator,
        pace: Pace = AS_PLANNED,
    ) -> "ParticleBelief":
        kernel = specialised(move_particles, **parts)
        uniforms, n_outcomes = rng.random(len(self.weights)), len(self.model.outcomes)
        for trust_outcome, trust_observation in ((True, True), (False, True), (True, False)):
            states = self.states.copy()
            outcomes, log_outcome, log_likelihood = kernel(
                arrays,
                states,
                action,
                evidence,
                n_outcomes,
                trust_outcome,
                trust_observation,
                uniforms,
            )
            log_weights = self.log_weights + log_likelihood
            if np.isfinite(log_weights.max()):
                break
        log_weights -= log_weights.max()
        weights = np.exp(log_weights)
        surprised = not (trust_outcome and trust_observation)
        history = self.history
        if history is not None:
            likelihood = self._likelihood(action, evidence) if trust_observation else np.ones(n_outcomes)
            history = history.then(action, outcomes, likelihood, log_outcome, pace)
        belief = replace(
            self,
            states=self.model.rested(states, pace.rest_s) if pace.rest_s > 0 else states,
            weights=weights / weights.sum(),
            log_weights=log_weights,
            surprised=surprised,
            history=history,
        )
        if surprised or belief.effective_size() < MIN_EFFECTIVE_FRACTION * len(weights):
            return belief.resampled(rng)
        return belief

    def _likelihood(self, action: int, evidence: Any) -> Vector:
        """The likelihood of every outcome (U,) in the fatigue problem, the only one of which a history is recorded."""
        observed = isinstance(evidence, int | np.integer)
        arrays = self.model.arrays
        return np.asarray(arrays.observation[recognition_of(arrays, action), :, evidence] if observed else evidence)

    def among(self, chosen: NDArray[np.bool_]) -> Self:
        """See Belief.among."""
        log_weights = self.log_weights[chosen] - self.log_weights[chosen].max()
        weights = np.exp(log_weights)
        history = self.history and self.history.pick(np.flatnonzero(chosen))
        states = self.states[chosen]
        return replace(self, states=states, weights=weights / weights.sum(), log_weights=log_weights, history=history)

    def resampled(self, rng: np.random.Generator) -> "ParticleBelief":
        """Equally weighted particles by systematic resampling, then rejuvenated."""
        count = len(self.weights)
        ends = np.cumsum(self.weights)
        positions = (rng.random() + np.arange(count)) / count * ends[-1]
        chosen = np.minimum(np.searchsorted(ends, positions, side="right"), np.flatnonzero(self.weights)[-1])
        equal = np.full(count, 1 / count)
        history = self.history and self.history.pick(chosen)
        belief = replace(self, states=self.states[chosen], weights=equal, log_weights=np.zeros(count), history=history)
        return belief.rejuvenated(rng)

    def rejuvenated(self, rng: np.random.Generator) -> "ParticleBelief":
        """The same belief; subclasses with hidden parameters move them (resample-move)."""
        return self


def move_particles(
    arrays: object,
    states: Array,
    action: int,
    observation: Any,
    outcomes: int,
    trust_outcome: bool,
    trust_observation: bool,
    uniforms: Vector,
) -> tuple[NDArray[np.int16], Vector, Vector]:
    """Template: move every particle in place.

    Returns for each particle (n,): its outcome, log P(outcome | s, a), and log P(o | s, a), -inf if impossible.
    """
    count = len(states)
    chosen = np.zeros(count, np.int16)
    log_outcome, log_likelihood = np.empty(count), np.empty(count)
    probabilities, posterior = np.empty(outcomes), np.empty(outcomes)
    moved = np.empty((outcomes, states.shape[1]))
    for i in range(count):
        outcome_probabilities(arrays, states[i], action, probabilities)
        total = 0.0
        for outcome in range(outcomes):
            moved[outcome] = states[i]
            advance(arrays, moved[outcome], action, outcome)
            posterior[outcome] = probabilities[outcome] if trust_outcome else 1.0
            if trust_observation:
                posterior[outcome] *= observation_probability(arrays, moved[outcome], action, outcome, observation)
            total += posterior[outcome]
        log_likelihood[i] = np.log(total)
        if total > 0:
            for outcome in range(outcomes):
                posterior[outcome] /= total
            chosen[i] = draw(posterior, uniforms[i])
        log_outcome[i] = np.log(max(probabilities[chosen[i]], MIN_PROBABILITY))
        states[i] = moved[chosen[i]]
    return chosen, log_outcome, log_likelihood

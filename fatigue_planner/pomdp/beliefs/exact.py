"""The exact belief: all possible states with their probabilities.

With finitely many initial states and outcomes nothing has to be sampled. The set stays small where the
observation reveals the outcome (paper, section III-B), or where different histories lead to the same state.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from fatigue_planner.core.jit import inlined, specialised
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.beliefs.bounded import bounded
from fatigue_planner.pomdp.problem import Observation, Vector, advance, observation_probability, outcome_probabilities

# No state that remains possible is forgotten, however unlikely: it is what remains if the others turn out to be
# impossible.
MIN_WEIGHT = 1e-300


@dataclass(frozen=True)
class ExactBelief(Belief):
    """A finite set of states and their exact probabilities.

    >>> from tiger import PROBLEM  # examples/tiger.py
    >>> heard = fp.ExactBelief(PROBLEM, np.array([[0.0], [1.0]]), np.array([0.5, 0.5])).update(2, 0, None)
    >>> heard.weights.round(2).tolist()
    [0.85, 0.15]
    """

    def update(self, action: int, observation: Observation, rng: np.random.Generator) -> "ExactBelief":
        """Bayes' rule.

        b'(s') is proportional to the sum over s, u of P(o | s', a, u) P(u | s, a) b(s), with s' the state u
        leads to. Where that is 0 for all, the worker must have chosen an outcome that the model holds
        impossible: P(u | s, a) is replaced by 1. If no outcome leads to the observation, the observation is
        ignored. No weight falls below MIN_WEIGHT. `rng` is not used.
        """
        self.model.check(action, observation)
        permitting = self.permitting(action)
        if permitting is not self:
            return permitting.update(action, observation, rng)
        self.model.check_again(self.states, action)
        states, weights, surprised = self._explaining(self.model.belief_parts, self.model.arrays, action, observation)
        if weights.size > self.weights.size:
            states, group = np.unique(states, axis=0, return_inverse=True)
            weights = np.asarray(np.bincount(group.ravel(), weights), float)
        normalise(weights)
        return ExactBelief(self.model, states, weights, surprised)

    def weigh(
        self, action: int, likelihood: ArrayLike, rng: np.random.Generator, *, duration_s: float | None = None
    ) -> Self:
        """See Belief.weigh. States closer than EQUAL_FATIGUE are merged, more than MAX_STATES thinned (see `bounded`).

        `rng` is only used for that.
        """
        model = self.model
        likelihood, pace = model.check_likelihood(action, likelihood), model.pace(duration_s)
        permitting = self.permitting(action)
        model.check_again(permitting.states, action)
        arrays = model.evidence_arrays(pace.share)
        states, weights, surprised = permitting._explaining(model.evidence_parts, arrays, action, likelihood)
        states, weights = bounded(model, states, weights, rng)
        if pace.rest_s > 0:
            states = model.rested(states, pace.rest_s)
        return replace(self, states=states, weights=weights, surprised=surprised)

    def rest(self, seconds: float) -> Self:
        """See Belief.rest."""
        return replace(self, states=self.model.rested(self.states, seconds))

    def _explaining(
        self, parts: Mapping[str, Any], arrays: Any, action: int, evidence: Any
    ) -> tuple[Array, Vector, bool]:
        """The states that explain the evidence, their weights, of which the largest is 1, and if it was a surprise."""
        kernel = specialised(bayes, **parts)
        for trust_outcome, trust_observation in ((True, True), (False, True), (True, False)):
            states, log_weights = kernel(
                arrays,
                self.states,
                self.weights,
                action,
                evidence,
                len(self.model.outcomes),
                trust_outcome,
                trust_observation,
            )
            if log_weights.size:
                break
        relative_weights(log_weights)
        return states, log_weights, not (trust_outcome and trust_observation)


@inlined
def relative_weights(log_weights: Vector) -> None:
    """In place, from log weights: weights of which the largest is 1 and none is below MIN_WEIGHT."""
    largest = -np.inf
    for i in range(log_weights.size):
        largest = max(largest, log_weights[i])
    for i in range(log_weights.size):
        log_weights[i] = max(math.exp(log_weights[i] - largest), MIN_WEIGHT)


@inlined
def normalise(weights: Vector) -> None:
    """Divide weights by their sum, in place."""
    total = 0.0
    for i in range(weights.size):
        total += weights[i]
    for i in range(weights.size):
        weights[i] /= total


def bayes(
    arrays: object,
    states: Array,
    weights: Vector,
    action: int,
    observation: Any,
    outcomes: int,
    trust_outcome: bool,
    trust_observation: bool,
) -> tuple[Array, Vector]:
    """Template: the states that remain possible (m, L), and their log weights (m,), not normalised."""
    probabilities = np.empty(outcomes)
    moved = np.empty((weights.size * outcomes, states.shape[1]))
    log_weights = np.empty(weights.size * outcomes)
    kept = 0
    for i in range(weights.size):
        outcome_probabilities(arrays, states[i], action, probabilities)
        for outcome in range(outcomes):
            probability = probabilities[outcome] if trust_outcome else 1.0
            moved[kept] = states[i]
            advance(arrays, moved[kept], action, outcome)
            if trust_observation:
                probability *= observation_probability(arrays, moved[kept], action, outcome, observation)
            if weights[i] > 0 and probability > 0:
                log_weights[kept] = np.log(weights[i]) + np.log(probability)
                kept += 1
    return moved[:kept].copy(), log_weights[:kept].copy()

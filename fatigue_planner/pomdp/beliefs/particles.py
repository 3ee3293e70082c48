"""The particle filter, for beliefs that no finite set can hold."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.compiled import specialised
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.problem import (
    Pomdp,
    Vector,
    advance,
    draw,
    observation_probability,
    outcome_probabilities,
)

# Resample where fewer than this share of the particles would carry the belief (the usual choice).
LEAST_EFFECTIVE_SHARE = 0.5


@dataclass(frozen=True)
class History:
    """What a particle filter remembers: actions (t,), and of each particle its start (n, L) and outcomes (n, t)."""

    start: Array
    actions: NDArray[np.int64]
    outcomes: NDArray[np.int64]

    def then(self, action: int, outcomes: NDArray[np.int64]) -> "History":
        """One more cycle."""
        return History(self.start, np.append(self.actions, action), np.column_stack([self.outcomes, outcomes]))

    def pick(self, chosen: NDArray[np.intp]) -> "History":
        """The past of some of the particles."""
        return History(self.start[chosen], self.actions, self.outcomes[chosen])


@dataclass(frozen=True)
class ParticleBelief(Belief):
    """Particles with log weights (n,); `weights` are these, normalised.

    As the likelihoods are known, an outcome is drawn from P(u | s, a, o) and the particle weighted by
    P(o | s, a) = sum over u of P(o | s', a, u) P(u | s, a): no particle is drawn against the observation.
    """

    history: History | None = None

    @staticmethod
    def begin(model: Pomdp, states: Array) -> "ParticleBelief":
        """Equally likely states (n, L)."""
        count = len(states)
        nothing = np.zeros(0, np.int64)
        history = History(states.copy(), nothing, np.zeros((count, 0), np.int64))
        return ParticleBelief(model, states.copy(), np.full(count, 1 / count), history=history)

    def effective_size(self) -> float:
        """Kong's effective sample size, 1 / sum of the squared weights."""
        return float(1 / np.square(self.weights).sum())

    def update(self, action: int, observation: int, rng: np.random.Generator) -> "ParticleBelief":
        """See Belief.update; an impossible observation is met as by the exact belief."""
        assert self.history is not None
        kernel = specialised(move_particles, **{name: self.model.parts[name] for name in PARTS})
        uniforms = rng.random(len(self.weights))
        for trust_outcome, trust_observation in ((True, True), (False, True), (True, False)):
            states = self.states.copy()
            outcomes, log_likelihood = kernel(
                self.model.arrays,
                states,
                action,
                observation,
                len(self.model.outcomes),
                trust_outcome,
                trust_observation,
                uniforms,
            )
            with np.errstate(divide="ignore"):
                log_weights = np.log(self.weights) + log_likelihood
            if np.isfinite(log_weights.max()):
                break
        weights = np.exp(log_weights - log_weights.max())
        surprised = not (trust_outcome and trust_observation)
        history = self.history.then(action, outcomes)
        belief = replace(self, states=states, weights=weights / weights.sum(), surprised=surprised, history=history)
        if belief.effective_size() < LEAST_EFFECTIVE_SHARE * len(weights):
            return belief.resampled(rng)
        return belief

    def resampled(self, rng: np.random.Generator) -> "ParticleBelief":
        """Equally weighted particles, drawn systematically, then rejuvenated by the model if it knows how."""
        assert self.history is not None
        count = len(self.weights)
        places = (rng.random() + np.arange(count)) / count
        chosen = np.minimum(np.searchsorted(np.cumsum(self.weights), places, side="right"), count - 1)
        equal = np.full(count, 1 / count)
        belief = replace(self, states=self.states[chosen], weights=equal, history=self.history.pick(chosen))
        return belief.rejuvenated(rng)

    def rejuvenated(self, rng: np.random.Generator) -> "ParticleBelief":
        """The same belief; where parameters are hidden, a kind of belief of its own moves them."""
        return self


PARTS = ("outcome_probabilities", "advance", "observation_probability")


def move_particles(
    arrays: object,
    states: Array,
    action: int,
    observation: int,
    outcomes: int,
    trust_outcome: bool,
    trust_observation: bool,
    uniforms: Vector,
) -> tuple[NDArray[np.int64], Vector]:
    """Template: move every particle in place; its outcome (n,) and log P(o | s, a) (n,), -inf if impossible."""
    count = len(states)
    chosen = np.zeros(count, np.int64)
    log_likelihood = np.empty(count)
    posterior = np.empty(outcomes)
    moved = np.empty((outcomes, states.shape[1]))
    for i in range(count):
        outcome_probabilities(arrays, states[i], action, posterior)
        total = 0.0
        for outcome in range(outcomes):
            moved[outcome] = states[i]
            advance(arrays, moved[outcome], action, outcome)
            if not trust_outcome:
                posterior[outcome] = 1.0
            if trust_observation:
                posterior[outcome] *= observation_probability(arrays, moved[outcome], action, outcome, observation)
            total += posterior[outcome]
        log_likelihood[i] = np.log(total)
        if total > 0:
            for outcome in range(outcomes):
                posterior[outcome] /= total
            chosen[i] = draw(posterior, uniforms[i])
        states[i] = moved[chosen[i]]
    return chosen, log_likelihood

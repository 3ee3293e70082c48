"""The particle filter over fatigue and the worker's hidden parameters."""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled, inlined
from fatigue_planner.pomdp.beliefs.particles import MIN_PROBABILITY, History, ParticleBelief
from fatigue_planner.pomdp.fatigue_pomdp import (
    FatigueArrays,
    FatiguePomdp,
    Workers,
    first_row,
    preference_probabilities,
)
from fatigue_planner.pomdp.hidden_worker import WorkerPrior
from fatigue_planner.pomdp.simd import move

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


# Proposals change a worker's quantile by up to 0.5, or by as little as this times that: the sizes are spread evenly
# over the orders of magnitude, so that some fit however much is known.
MIN_STEP = 1e-3
NO_REST = np.zeros((0, 0))


@dataclass(frozen=True)
class HiddenWorkerBelief(ParticleBelief):
    """Particles that each have their own worker, whose index in the model is in their state.

    quantiles (n, 3): of the model's workers in the prior's distributions, between 0 and 1
    """

    model: FatiguePomdp
    quantiles: Array = field(kw_only=True)
    prior: WorkerPrior = field(kw_only=True)
    history: History = field(kw_only=True)

    @staticmethod
    def start(model: FatiguePomdp, states: Array, prior: WorkerPrior, rng: np.random.Generator) -> "HiddenWorkerBelief":
        """Equally likely states (n, L), each with a worker drawn from the prior."""
        count = len(states)
        quantiles = rng.random((count, len(Workers._fields)))
        numbered = states.copy()
        numbered[:, -1] = np.arange(count)
        return HiddenWorkerBelief(
            model.for_workers(prior.at(quantiles)),
            numbered,
            np.full(count, 1 / count),
            log_weights=np.zeros(count),
            quantiles=quantiles,
            prior=prior,
            history=History.begin(numbered),
        )

    def workers(self) -> Workers:
        """Every particle's worker, (n,)."""
        return self.model.workers.pick(self.states[:, -1].astype(np.intp))

    def rejuvenated(self, rng: np.random.Generator) -> "HiddenWorkerBelief":
        """Particles with new workers: resample-move (Gilks & Berzuini 2001), which leaves the posterior unchanged.

        It prevents particle deprivation: after resampling, many particles have the same worker.

        One hidden parameter after the other is proposed a random step along its distribution, wrapped around at the
        ends. It is accepted with the ratio of the likelihoods of the particle's past outcomes (Metropolis-Hastings:
        quantiles are uniformly distributed, so the prior cancels out). The fatigue becomes that of the new worker
        after the same past.
        """
        history, count = self.history, len(self.states)
        states, log_likelihood = self.states.copy(), history.log_likelihood
        quantiles = self.quantiles[states[:, -1].astype(np.intp)]
        start = history.start.copy()
        start[:, -1] = states[:, -1] = np.arange(count)
        for column in self.prior.hidden():
            step = MIN_STEP ** rng.random(count) * (rng.random(count) - 0.5)
            proposed = quantiles.copy()
            proposed[:, column] = (quantiles[:, column] + step) % 1 % 1  # -1e-20 % 1 is 1
            moved = start.copy()
            likelihood = relive(self.model.for_workers(self.prior.at(proposed)), moved, history)
            accepted = rng.random(count) < np.exp(np.minimum(likelihood - log_likelihood, 0))
            quantiles = np.where(accepted[:, None], proposed, quantiles)
            states = np.where(accepted[:, None], moved, states)
            log_likelihood = np.where(accepted, likelihood, log_likelihood)
        return replace(
            self,
            model=self.model.for_workers(self.prior.at(quantiles)),
            quantiles=quantiles,
            states=states,
            history=replace(history, start=start, log_likelihood=log_likelihood),
        )


class Past(NamedTuple):
    """What `live_again` reads of a history, and of the workers it is lived by.

    actions (t,), outcomes (n, t), rest_s (t + 1,): see History. gain, offset (tables * M * A * U, W): the cycle maps as
    lived, of which cycle i is in table number tables[i]; fade, grow (M, W): at rest, df/dt = grow - fade f
    """

    actions: NDArray[np.int64]
    outcomes: NDArray[np.int16]
    rest_s: Vector
    gain: Array
    offset: Array
    tables: NDArray[np.intp]
    fade: Array
    grow: Array


def relive(model: FatiguePomdp, states: Array, history: History) -> Vector:
    """Take states (n, L) in place through the past of particles (n,); log of their outcomes' probability, (n,)."""
    shares, tables = np.unique(history.shares, return_inverse=True)
    lived = [model.evidence_arrays(share).lived for share in shares] or [model.arrays]
    gain, offset = lived[0].gain, lived[0].offset
    if len(lived) > 1:
        gain, offset = (np.concatenate([getattr(arrays, name) for arrays in lived]) for name in ("gain", "offset"))
    fade, grow = model.rest_rates() if history.rest_s.any() else (NO_REST, NO_REST)
    past = Past(history.actions, history.outcomes, history.rest_s, gain, offset, tables, fade, grow)
    return live_again(model.arrays, past, states, len(model.outcomes))


@inlined
def pause(past: Past, state: Vector, number: int) -> None:
    """Let the worker of a state rest for pause `number`. Neighbouring entries often fade at the same rate."""
    seconds = past.rest_s[number]
    if seconds > 0:
        worker = int(state[state.size - 1])
        left, held, last = 1.0, seconds, 0.0
        for j in range(state.size - 1):
            fade = past.fade[worker, j]
            if fade != last:
                left = math.exp(-fade * seconds)
                held = -math.expm1(-fade * seconds) / fade if fade > 0 else seconds
                last = fade
            state[j] = left * state[j] + past.grow[worker, j] * held


@compiled
def live_again(arrays: FatigueArrays, past: Past, states: Array, n_outcomes: int) -> Vector:
    """See `relive`."""
    log_likelihood = np.zeros(len(states))
    probabilities = np.empty(n_outcomes)
    rows = arrays.gain.shape[0]
    for i in range(len(states)):
        pause(past, states[i], 0)
        for t in range(past.actions.size):
            preference_probabilities(arrays, states[i], past.actions[t], probabilities)
            log_likelihood[i] += np.log(max(probabilities[past.outcomes[i, t]], MIN_PROBABILITY))
            row = first_row(arrays, states[i], past.actions[t]) + past.outcomes[i, t]
            move(past.gain, past.offset, states[i], past.tables[t] * rows + row)
            pause(past, states[i], t + 1)
    return log_likelihood

"""The particle filter over fatigue and the worker's hidden parameters."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.pomdp.beliefs.particles import MIN_PROBABILITY, History, ParticleBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatigueArrays, FatiguePomdp, Workers, preference_probabilities, react
from fatigue_planner.pomdp.hidden_worker import WorkerPrior

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


# Proposals change a worker's quantile by up to 0.5, or by as little as this times that: the sizes are spread evenly
# over the orders of magnitude, so that some fit however much is known.
MIN_STEP = 1e-3


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
            arrays = self.model.for_workers(self.prior.at(proposed)).arrays
            likelihood = relive(arrays, moved, history.actions, history.outcomes, len(self.model.outcomes))
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


@compiled
def relive(
    arrays: FatigueArrays, states: Array, actions: NDArray[np.int64], outcomes: NDArray[np.int16], n_outcomes: int
) -> Vector:
    """Take states (n, L) in place through actions (t,) and outcomes (n, t); log of the outcomes' probability (n,)."""
    log_likelihood = np.zeros(len(states))
    probabilities = np.empty(n_outcomes)
    for i in range(len(states)):
        for t in range(actions.size):
            preference_probabilities(arrays, states[i], actions[t], probabilities)
            log_likelihood[i] += np.log(max(probabilities[outcomes[i, t]], MIN_PROBABILITY))
            react(arrays, states[i], actions[t], outcomes[i, t])
    return log_likelihood

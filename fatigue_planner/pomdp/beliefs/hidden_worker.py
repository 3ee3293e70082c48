"""The particle filter over fatigue and the worker's hidden parameters."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.compiled import compiled
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief
from fatigue_planner.pomdp.fatigue_model import FatigueArrays, FatiguePomdp, Workers, preference_probabilities, react
from fatigue_planner.pomdp.hidden_worker import WorkerPrior

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class HiddenWorkerBelief(ParticleBelief):
    """Particles that each have a worker of their own; particle i's is number i of the model."""

    prior: WorkerPrior | None = None

    @staticmethod
    def start(model: FatiguePomdp, states: Array, prior: WorkerPrior, rng: np.random.Generator) -> "HiddenWorkerBelief":
        """Equally likely states (n, L), each with a worker drawn from the prior."""
        workers = prior.at(rng.random((len(states), len(Workers._fields))))
        numbered = states.copy()
        numbered[:, -1] = np.arange(len(states))
        plain = ParticleBelief.begin(model.for_workers(workers), numbered)
        return HiddenWorkerBelief(plain.model, plain.states, plain.weights, history=plain.history, prior=prior)

    def rejuvenated(self, rng: np.random.Generator) -> "HiddenWorkerBelief":
        """Particles with new workers: resample-move (Gilks & Berzuini 2001), which leaves the posterior as it is.

        One parameter after the other is proposed from its prior, and accepted with the ratio of the
        likelihoods of the particle's past outcomes (Metropolis-Hastings; the prior cancels out). The fatigue
        is then what that worker's past comes to.
        """
        model, history = self.model, self.history
        assert isinstance(model, FatiguePomdp) and history is not None and self.prior is not None
        count = len(self.states)
        own = np.arange(count)
        workers = model.workers.pick(self.states[:, -1].astype(np.intp))
        start = history.start.copy()
        start[:, -1] = own
        now = model.for_workers(workers)
        states, log_likelihood = _replay(now, start, history.actions, history.outcomes)
        for name in Workers._fields:
            proposal = self.prior.at(rng.random((count, len(Workers._fields))))
            tried = workers._replace(**{name: getattr(proposal, name)})
            moved, likelihood = _replay(model.for_workers(tried), start, history.actions, history.outcomes)
            with np.errstate(invalid="ignore"):  # -inf - -inf: a past impossible for both stays as it is
                accepted = np.log(rng.random(count)) < likelihood - log_likelihood
            workers = Workers(*(np.where(accepted, new, old) for new, old in zip(tried, workers, strict=True)))
            states = np.where(accepted[:, None], moved, states)
            log_likelihood = np.where(accepted, likelihood, log_likelihood)
        return replace(self, model=model.for_workers(workers), states=states, history=replace(history, start=start))


def _replay(
    model: FatiguePomdp, start: Array, actions: NDArray[np.int64], outcomes: NDArray[np.int64]
) -> tuple[Array, Vector]:
    states = start.copy()
    return states, relive(model.arrays, states, actions, outcomes, len(model.outcomes))


@compiled
def relive(
    arrays: FatigueArrays, states: Array, actions: NDArray[np.int64], outcomes: NDArray[np.int64], n_outcomes: int
) -> Vector:
    """Take states (n, L) in place through actions (t,) and outcomes (n, t); log of the outcomes' probability (n,)."""
    log_likelihood = np.zeros(len(states))
    probabilities = np.empty(n_outcomes)
    for i in range(len(states)):
        for t in range(actions.size):
            preference_probabilities(arrays, states[i], actions[t], probabilities)
            log_likelihood[i] += np.log(probabilities[outcomes[i, t]])
            react(arrays, states[i], actions[t], outcomes[i, t])
    return log_likelihood

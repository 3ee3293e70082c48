"""The particle filter over fatigue and the worker's hidden parameters."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fatigue_planner.pomdp.beliefs.forgotten import Forgotten, design, fitted
from fatigue_planner.pomdp.beliefs.history import History, evidence_again, lived_by, relive
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers
from fatigue_planner.pomdp.hidden_worker import WorkerPrior

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


# Proposals change a worker's quantile by up to 0.5, or by as little as this times that: the sizes are spread evenly
# over the orders of magnitude, so that some fit however much is known.
MIN_STEP = 1e-3
# Cycles pass into `History.forgotten` by so many.
BLOCK = 100
# Particles of the filters that find out what they told.
FILTER = 32
# Cycles are forgotten one by one when less than this is left of the fatigue before them, or MAX_REMEMBERED later.
REMNANT = 1e-6
MAX_REMEMBERED = 400


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

    def weigh(
        self, action: int, likelihood: ArrayLike, rng: np.random.Generator, *, duration_s: float | None = None
    ) -> "HiddenWorkerBelief":
        """See Belief.weigh; the history stays bounded."""
        after = super().weigh(action, likelihood, rng, duration_s=duration_s)
        assert isinstance(after, HiddenWorkerBelief)
        return after.settling(rng)

    def warm_up(self) -> None:
        """See Belief.warm_up."""
        super().warm_up()
        rng = np.random.default_rng(0)
        self._told_by(self.weigh(0, np.ones(len(self.model.outcomes)), rng).history, rng)

    def settling(self, rng: np.random.Generator) -> "HiddenWorkerBelief":
        """The belief whose history remembers a bounded number of cycles one by one, and of the others what they told.

        Of 2 * BLOCK cycles in the likelihood, the first half is settled: it goes into `History.forgotten`. Of settled
        cycles, only those are kept that the fatigue has not forgotten.
        """
        history = self.history
        if history.actions.size - history.settled < 2 * BLOCK:
            return self
        settled = history.settled + BLOCK
        told = self._told_by(history.first(settled), rng)
        forgotten = told if history.forgotten is None else history.forgotten.and_then(told)
        gone = max(0, settled - self._cycles_to_forget())
        start = history.start.copy()
        relive(self.model, start, history.first(gone))
        history = replace(history, settled=settled, forgotten=forgotten).without(gone, start)
        log_likelihood = relive(self.model, start.copy(), history)
        return replace(self, history=replace(history, log_likelihood=log_likelihood))

    def _told_by(self, history: History, rng: np.random.Generator) -> Forgotten:
        """What the cycles since a history settled tell about the worker."""
        quantiles = self.quantiles[self.states[:, -1].astype(np.intp)]
        blocks = 0 if history.forgotten is None else history.forgotten.blocks
        quantiles = design(self.prior, quantiles, self.weights, blocks + 2, rng)
        model = self.model.for_workers(self.prior.at(quantiles))
        chosen = rng.choice(len(self.weights), FILTER, p=self.weights)
        uniforms = rng.random((history.actions.size, FILTER + 1))
        past = lived_by(model, history.pick(chosen))
        values = evidence_again(model.arrays, past, history.start[chosen], uniforms, len(model.outcomes))
        return fitted(self.prior, quantiles, values)

    def _cycles_to_forget(self) -> int:
        """After how many cycles the most enduring fatigue of any of the workers is a REMNANT of what it was."""
        slowest = float(self.model.arrays.gain.max())
        if slowest >= REMNANT ** (1 / MAX_REMEMBERED):
            return MAX_REMEMBERED
        return math.ceil(math.log(REMNANT) / math.log(slowest)) if slowest > 0 else 1

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
            gained = likelihood - log_likelihood
            if history.forgotten is not None:
                gained += history.forgotten.log_likelihood(self.prior, proposed)
                gained -= history.forgotten.log_likelihood(self.prior, quantiles)
            accepted = rng.random(count) < np.exp(np.minimum(gained, 0))
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

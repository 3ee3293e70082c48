"""The beliefs that an experiment file can name, and the default where it names none.

To add a belief: write it (see `belief.Belief`); here, its settings (see BeliefSettings) and a name in the last loop.
From outside the package: `fatigue_planner.register` (see `core.plugins`).
"""

from abc import abstractmethod
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from fatigue_planner.core.plugins import Registry
from fatigue_planner.core.settings import Settings
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.beliefs.hidden_worker import HiddenWorkerBelief
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.hidden_worker import WorkerPrior
from fatigue_planner.pomdp.problem import Vector

# The most workers in an exact set; every cycle and every descent of a search goes through all of them.
MAX_EXACT = 1000


class BeliefSettings(Settings):
    """What an experiment file says about a belief; every kind has `kind: Literal["its name"]` and keys of its own.

    >>> experiment.belief is None and isinstance(scenario.belief, fp.BeliefSettings)
    True
    """

    kind: str

    @abstractmethod
    def build(
        self,
        model: FatiguePomdp,
        states: Array,
        weights: Vector,
        prior: WorkerPrior | None,
        rng: np.random.Generator,
    ) -> Belief:
        """The belief in states (n, L) with probabilities (n,), of workers from the prior (None: the model's)."""


class ExactSettings(BeliefSettings):
    """The exact weighted set."""

    kind: Literal["exact"] = Field(description="The exact weighted set of states.")

    def build(
        self,
        model: FatiguePomdp,
        states: Array,
        weights: Vector,
        prior: WorkerPrior | None,
        rng: np.random.Generator,
    ) -> Belief:
        """See BeliefSettings.build."""
        if prior is None:
            return ExactBelief(model, states, weights)
        workers, probabilities = prior.support()
        repeated = np.repeat(states, probabilities.size, axis=0)
        repeated[:, -1] = np.tile(np.arange(probabilities.size), len(states))
        return ExactBelief(model.for_workers(workers), repeated, np.outer(weights, probabilities).ravel())


class ParticleSettings(BeliefSettings):
    """A particle filter."""

    kind: Literal["particles"] = Field(description="A particle filter.")
    count: int = Field(ge=1, le=1_000_000, description="Number of particles.")

    def build(
        self,
        model: FatiguePomdp,
        states: Array,
        weights: Vector,
        prior: WorkerPrior | None,
        rng: np.random.Generator,
    ) -> Belief:
        """See BeliefSettings.build."""
        drawn = states[rng.choice(len(states), size=self.count, p=weights)]
        if prior is None:
            return ParticleBelief.begin(model, drawn)
        return HiddenWorkerBelief.start(model, drawn, prior, rng)


# The default where no finite set can represent the belief.
DEFAULT_PARTICLES = ParticleSettings(kind="particles", count=300)


def default_belief(observation_reveals_outcome: bool, prior: WorkerPrior | None) -> BeliefSettings:
    """The exact set where it stays small: reactions are recognised without error, and workers are few."""
    few = prior is None or prior.size <= MAX_EXACT
    return ExactSettings(kind="exact") if observation_reveals_outcome and few else DEFAULT_PARTICLES


BELIEFS = Registry("belief", BeliefSettings)  # type: ignore[type-abstract]
for kind in (ExactSettings, ParticleSettings):
    BELIEFS.add(kind)

# The settings of any belief.
AnyBelief = Annotated[BeliefSettings, BELIEFS]

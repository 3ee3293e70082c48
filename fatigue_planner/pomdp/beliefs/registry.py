"""The beliefs an experiment file can name, and the one that fits where it names none.

To add a belief: write it (see `belief.Belief`); here, describe its settings, name them in BeliefSettings and
add a line to BELIEF_KINDS.
"""

from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from fatigue_planner.core.settings import Settings
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.beliefs.hidden_worker import HiddenWorkerBelief
from fatigue_planner.pomdp.beliefs.particles import ParticleBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.hidden_worker import WorkerPrior
from fatigue_planner.pomdp.problem import Vector


class ExactSettings(Settings):
    """The exact weighted set."""

    kind: Literal["exact"] = Field(description="The exact weighted set of states.")


class ParticleSettings(Settings):
    """A particle filter."""

    kind: Literal["particles"] = Field(description="A particle filter.")
    count: int = Field(ge=1, le=1_000_000, description="Number of particles.")


BeliefSettings = Annotated[ExactSettings | ParticleSettings, Field(discriminator="kind")]

# Where the file names no belief and no finite set holds it.
USUAL_PARTICLES = ParticleSettings(kind="particles", count=300)
# The exact set may hold so many workers; every cycle and every descent of a search goes through them.
MAX_EXACT = 1000

Builder = Callable[[FatiguePomdp, Array, Vector, WorkerPrior | None, Any, np.random.Generator], Belief]


def fitting(observation_reveals_outcome: bool, prior: WorkerPrior | None) -> ExactSettings | ParticleSettings:
    """The exact set where it stays small: reactions recognised without error, not too many workers."""
    few = prior is None or prior.size <= MAX_EXACT
    return ExactSettings(kind="exact") if observation_reveals_outcome and few else USUAL_PARTICLES


def _exact(
    model: FatiguePomdp,
    states: Array,
    weights: Vector,
    prior: WorkerPrior | None,
    _settings: ExactSettings,
    _rng: np.random.Generator,
) -> Belief:
    if prior is None:
        return ExactBelief(model, states, weights)
    workers, chances = prior.support()
    repeated = np.repeat(states, chances.size, axis=0)
    repeated[:, -1] = np.tile(np.arange(chances.size), len(states))
    return ExactBelief(model.for_workers(workers), repeated, np.outer(weights, chances).ravel())


def _particles(
    model: FatiguePomdp,
    states: Array,
    weights: Vector,
    prior: WorkerPrior | None,
    settings: ParticleSettings,
    rng: np.random.Generator,
) -> Belief:
    drawn = states[rng.choice(len(states), size=settings.count, p=weights)]
    if prior is None:
        return ParticleBelief.begin(model, drawn)
    return HiddenWorkerBelief.start(model, drawn, prior, rng)


BELIEF_KINDS: dict[str, Builder] = {"exact": _exact, "particles": _particles}


def initial_belief(
    model: FatiguePomdp,
    states: Array,
    weights: Vector,
    prior: WorkerPrior | None,
    settings: ExactSettings | ParticleSettings,
    rng: np.random.Generator,
) -> Belief:
    """The belief in states (n, L) with probabilities (n,), of workers as the prior has them (None: the model's)."""
    return BELIEF_KINDS[settings.kind](model, states, weights, prior, settings, rng)

"""A condition as the planners meet it: the task, where the worker may start, and what is hidden about him."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.files import digest_of
from fatigue_planner.core.plugins import plugin_sources
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.registry import BeliefSettings, ExactSettings
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers, fingerprint
from fatigue_planner.pomdp.hidden_worker import WorkerPrior
from fatigue_planner.pomdp.problem import draw

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# What a policy knows about a worker with hidden parameters.
Knowledge = Literal["prior", "average", "truth"]


@dataclass(frozen=True)
class Scenario:
    """The model has the average worker; states (n, L) and weights (n,) are where he may start.

    prior: the distribution of the worker, None where the worker is known; belief: how beliefs are kept; name: of the
    condition, by which random numbers are drawn.

    >>> isinstance(scenario, fp.Scenario), scenario.leaves_nothing_to_chance()
    (True, False)
    """

    model: FatiguePomdp
    states: Array
    weights: Vector
    prior: WorkerPrior | None
    belief: BeliefSettings
    name: str = ""

    def worker(self, uniforms: Vector) -> FatiguePomdp:
        """The model with the worker at the quantiles `uniforms` (3,) of the prior."""
        if self.prior is None:
            return self.model
        return self.model.for_workers(self.prior.at(uniforms[None]))

    def start_number(self, uniform: float) -> int:
        """Which of the states the worker starts in, for a uniform draw from [0, 1)."""
        return int(draw(self.weights, uniform))

    def start(self, uniform: float) -> Vector:
        """The initial state for a uniform draw from [0, 1)."""
        return np.asarray(self.states[self.start_number(uniform)])

    def initial_belief(self, knows: Knowledge, true_model: FatiguePomdp, rng: np.random.Generator) -> Belief:
        """What a policy believes before the first cycle; `true_model` has the true worker."""
        if self.prior is None or knows == "prior":
            return self.belief.build(self.model, self.states, self.weights, self.prior, rng)
        model = true_model if knows == "truth" else self.model
        settings = ExactSettings(kind="exact") if model.observation_reveals_outcome else self.belief
        return settings.build(model, self.states, self.weights, None, rng)

    def leaves_nothing_to_chance(self) -> bool:
        """Whether the worker, his start and his choices are certain (paper, footnote 4)."""
        return (
            self.model.is_experts
            and len(self.weights) == 1
            and self.prior is None
            and self.model.observation_reveals_outcome
        )

    @cached_property
    def digest(self) -> str:
        """Digest of all that decides what happens in the scenario."""
        return digest_of(self.fingerprint())

    def fingerprint(self) -> dict[str, Any]:
        """All that decides what happens in the scenario, as JSON values."""
        prior, profiles = [], []
        if self.prior is not None:  # other workers' maps follow from the profiles
            prior = [distribution.plain() for distribution in self.prior.distributions]
            profiles = [[profile.plain() for profile in row] for row in self.model.profiles]
        return {
            "model": fingerprint(self.model),
            "profiles": profiles,
            "states": self.states.tolist(),
            "weights": self.weights.tolist(),
            "prior": prior,
            "belief": self.belief.plain() | plugin_sources(type(self.belief)),
        }


def average_worker(prior: WorkerPrior) -> Workers:
    """The worker at the median of every distribution."""
    return prior.at(np.full((1, len(Workers._fields)), 0.5))

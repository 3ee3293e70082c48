"""The policy `robust_periodic`: the best schedule over a distribution of workers."""

from typing import Literal

import numpy as np
from pydantic import Field

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.planners.periodic import Longest
from fatigue_planner.planners.policy import Policy, PolicySettings
from fatigue_planner.planners.schedules.policy import SchedulePolicy, best_schedule_for
from fatigue_planner.planners.schedules.search import LONGEST, Plan
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp, Workers
from fatigue_planner.pomdp.hidden_worker import HiddenWorker, LogNormal, WorkerPrior

# Individual k at the shoulder: 1.02 +- 0.49 per minute, 40 men (Ma et al. 2014, arXiv 1402.1713): a coefficient of
# variation of 0.48, which a log-normal factor has with this sigma. That of R is assumed to be the same.
SPREAD = LogNormal(kind="lognormal", median=1.0, sigma=0.456)
USUAL_WORKERS = HiddenWorker(fatigue_rate_factor=SPREAD, recovery_rate_factor=SPREAD)
# How many workers stand for a distribution that is not a list.
WORKERS = 32


def varied(belief: Belief, workers: HiddenWorker) -> ExactBelief:
    """The belief with every worker in it replaced by those of a distribution around him.

    Factors multiply; an expertise in the distribution takes the place of the worker's. Raises ProblemError for problems
    without workers.
    """
    model = belief.model
    if not isinstance(model, FatiguePomdp):
        raise ProblemError("robust_periodic: the problem has no workers.")
    prior = WorkerPrior(workers, 0.0)
    if prior.size <= WORKERS:
        others, shares = prior.support()
    else:
        others, shares = prior.at(_evenly_spread(WORKERS)), np.full(WORKERS, 1 / WORKERS)
    own, count = model.workers, shares.size
    known = np.repeat(own.expertise, count)
    several = Workers(
        np.outer(own.fatigue_rate_factor, others.fatigue_rate_factor).ravel(),
        np.outer(own.recovery_rate_factor, others.recovery_rate_factor).ravel(),
        known if workers.expertise is None else np.tile(others.expertise, own.expertise.size),
    )
    states = np.repeat(belief.states, count, axis=0)
    states[:, -1] = states[:, -1] * count + np.tile(np.arange(count), len(belief.states))
    return ExactBelief(model.for_workers(several), states, np.outer(belief.weights, shares).ravel())


def _evenly_spread(count: int) -> Array:
    """A Latin hypercube (count, 3): in every dimension the middles of so many equal intervals, in random order."""
    rng = random_stream(0, "workers of a distribution", count)
    return np.array([(rng.permutation(count) + 0.5) / count for _ in Workers._fields]).T


class RobustPeriodicPolicy(SchedulePolicy):
    """The schedule whose mean cost over the workers is lowest."""

    def __init__(self, settings: "RobustPeriodicSettings") -> None:
        super().__init__()
        self._settings = settings

    def schedule(self, belief: Belief) -> Plan:
        """See SchedulePolicy.schedule. Raises ProblemError for problems without workers."""
        return best_schedule_for(varied(belief, self._settings.workers), self._settings.longest).actions


class RobustPeriodicSettings(PolicySettings):
    """The schedule that is best on average over a distribution of workers."""

    kind: Literal["robust_periodic"] = Field(
        description="The schedule with the lowest mean cost over a distribution of workers, repeated for ever."
    )
    workers: HiddenWorker = Field(
        default=USUAL_WORKERS,
        description="Distribution of the workers around the condition's. Default: rates of fatigue and recovery with "
        "the spread measured at the shoulder (log-normal, sigma 0.456).",
    )
    longest: Longest = LONGEST

    def plans_endlessly(self) -> bool:
        """See PolicySettings.plans_endlessly."""
        return True

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return RobustPeriodicPolicy(self)

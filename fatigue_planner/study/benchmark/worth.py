"""What planning is worth over what is done without it, and closing the loop over the best schedule."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import pandas as pd

from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.baselines import GreedySettings
from fatigue_planner.planners.fixed import FixedSettings
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.periodic import PeriodicSettings
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.planners.robust_periodic import RobustPeriodicSettings
from fatigue_planner.planners.threshold import ThresholdSettings
from fatigue_planner.study.statistics.multiple_testing import Pair
from fatigue_planner.study.statistics.pairing import cells_of
from fatigue_planner.study.statistics.savings import Saving, savings


class Role(StrEnum):
    """What a policy stands for, in words."""

    FIXED = "a fixed action"
    REACTIVE = "a reactive rule"
    SCHEDULE = "a schedule"
    GREEDY = "greedy"
    PLANNING = "planning"


# What planning is compared with, and the kind of policy that adds it to a benchmark.
ALTERNATIVES = {Role.FIXED: "fixed", Role.REACTIVE: "threshold", Role.GREEDY: "greedy", Role.SCHEDULE: "periodic"}


@dataclass(frozen=True)
class PlanningWorth:
    """In one condition, what the best policy that plans saves of the cost of the best one of every other role."""

    condition: str
    n_cycles: int
    planner: str
    savings: Mapping[Role, Saving]


def role_of(settings: PolicySettings) -> Role | None:
    """The role of a policy; None for baselines, plug-ins, and what knows a hidden worker, as no robot does."""
    if settings.knows == "truth":
        return None
    if isinstance(settings, PeriodicSettings):
        steps = settings.longest if settings.sequence is None else len(set(settings.sequence))
        return Role.SCHEDULE if steps > 1 else Role.FIXED
    if isinstance(settings, RobustPeriodicSettings):
        return Role.SCHEDULE if settings.longest > 1 else Role.FIXED
    kinds: dict[type[PolicySettings], Role] = {
        FixedSettings: Role.FIXED, ThresholdSettings: Role.REACTIVE, GreedySettings: Role.GREEDY,
        PomcpSettings: Role.PLANNING, LookaheadSettings: Role.PLANNING,
    }  # fmt: skip
    return kinds.get(type(settings))


def roles_of(experiment: Experiment) -> dict[Role, list[str]]:
    """The policies of every role that the benchmark has."""
    found: dict[Role, list[str]] = {}
    for name, settings in experiment.benchmark.policies.items():
        if (role := role_of(settings)) is not None:
            found.setdefault(role, []).append(name)
    return found


def planning_worth(experiment: Experiment, trials: pd.DataFrame) -> list[PlanningWorth]:
    """Every cell in which some policy plans and another does not, from a table of trials.

    The best policy of a role is that with the best mean in the cell: the more a benchmark has of a role, the luckier.
    """
    roles = roles_of(experiment)
    found = []
    for condition, n_cycles, cell in cells_of(trials):
        means = cell.groupby("policy")["discounted_return"].mean()
        there = {role: [name for name in names if name in means.index] for role, names in roles.items()}
        best = {role: max(names, key=lambda name: float(means[name])) for role, names in there.items() if names}
        planner = best.pop(Role.PLANNING, None)
        if planner is None or not best:
            continue
        pairs = [Pair(condition, n_cycles, planner, best[role]) for role in ALTERNATIVES if role in best]
        saved = savings(trials, pairs, experiment.statistics, experiment.benchmark.seed)
        by_role = dict(zip([role for role in ALTERNATIVES if role in best], saved, strict=True))
        found.append(PlanningWorth(condition, n_cycles, planner, by_role))
    return found

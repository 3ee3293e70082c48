"""What a report is written from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from fatigue_planner.experiment.build import worker_fatigue
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.reactions.reaction import Reaction, ReactionName
from fatigue_planner.study.benchmark.replay import Course
from fatigue_planner.study.benchmark.results import Results
from fatigue_planner.study.statistics.regret import regret_table


@dataclass(frozen=True)
class ReportData:
    """An experiment, its reactions with what a cycle of each does, its tables and the courses of its runs."""

    experiment: Experiment
    reactions: Sequence[Reaction]
    profiles: Mapping[ReactionName, CycleProfile]
    results: Results
    courses: Mapping[tuple[str, int, str], Sequence[Course]]

    @property
    def policies(self) -> list[str]:
        """The names of the policies, in the experiment's order."""
        return list(self.experiment.benchmark.policies)

    @property
    def longest(self) -> int:
        """The largest number of cycles."""
        return max(self.experiment.benchmark.n_cycles)

    @property
    def anchor(self) -> str:
        """The policy that others are compared with in figures: the first greedy one, else the first one."""
        policies = self.experiment.benchmark.policies
        return next((name for name, settings in policies.items() if settings.kind == "greedy"), self.policies[0])

    @cached_property
    def fatigue(self) -> dict[str, FatigueParameters]:
        """The fatigue parameters of every worker."""
        return worker_fatigue(self.experiment)

    @cached_property
    def regret(self) -> pd.DataFrame | None:
        """Regret by cell, where it was measured."""
        if self.results.regret is None:
            return None
        return regret_table(self.results.trials.merge(self.results.regret))

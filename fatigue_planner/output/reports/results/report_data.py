"""What a report is written from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from fatigue_planner.experiment.build import worker_fatigue
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import Course
from fatigue_planner.study.benchmark.results import Results
from fatigue_planner.study.statistics.comparison import comparison_table
from fatigue_planner.study.statistics.contrasts import contrasts
from fatigue_planner.study.statistics.regret import gap_table, regret_table


@dataclass(frozen=True)
class ReportData:
    """An experiment, its reactions, its tables and the courses of its runs; all else follows from these.

    omissions: sentences on what of the experiment's file is not in it, because it cannot be performed.
    """

    experiment: Experiment
    reactions: Sequence[Reaction]
    grid: Sequence[Cell]
    results: Results
    courses: Mapping[tuple[str, int, str], Sequence[Course]]
    omissions: Sequence[str] = ()

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
    def comparison(self) -> pd.DataFrame:
        """Ranks and the paper's tests."""
        return comparison_table(self.results.trials, self.experiment.statistics.significance_level)

    @cached_property
    def contrasts(self) -> pd.DataFrame:
        """The modern statistics."""
        return contrasts(self.results.trials, self.experiment.statistics, self.experiment.benchmark.seed)

    @cached_property
    def regret(self) -> pd.DataFrame | None:
        """Regret by cell, where it was measured."""
        if self.results.regret is None:
            return None
        return regret_table(self.results.trials.merge(self.results.regret))

    @cached_property
    def gaps(self) -> pd.DataFrame | None:
        """How far every policy is from the cost none can beat, where that was computed."""
        if self.results.bounds is None:
            return None
        known = self.results.bounds.drop_duplicates(["condition", "n_cycles"])
        return gap_table(self.comparison, known[["condition", "n_cycles", "cost_bound", "exact"]])

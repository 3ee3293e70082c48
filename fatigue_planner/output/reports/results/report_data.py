"""What a report is written from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pandas as pd

from fatigue_planner.core.errors import ClaimsError
from fatigue_planner.experiment.build import worker_fatigue
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.output.reports.study.finished import FinishedStudy
from fatigue_planner.reactions.reaction import Reaction, ReactionName
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import Course
from fatigue_planner.study.benchmark.results import Results, courses
from fatigue_planner.study.benchmark.selection import cells
from fatigue_planner.study.claims.evaluation import Evaluation, evaluate
from fatigue_planner.study.claims.loader import Claims, load_claims
from fatigue_planner.study.statistics.regret import regret_table


@dataclass(frozen=True)
class ReportData:
    """An experiment, its reactions, what a cycle of each does to fatigue (`profiles`), and the tables of its results.

    `folder` holds the results, `file` is the experiment's, `commands` make the results and the report again,
    `studies` are those of the experiment. `omissions` are sentences on what of the experiment's file is left
    out, because it cannot be performed.
    """

    experiment: Experiment
    reactions: Sequence[Reaction]
    profiles: Mapping[ReactionName, CycleProfile]
    results: Results
    folder: Path
    file: Path
    commands: Sequence[str]
    studies: Sequence[FinishedStudy] = ()
    omissions: Sequence[str] = ()

    @property
    def study(self) -> FinishedStudy | None:
        """The first study that changes all settings at once."""
        return next((study for study in self.studies if study.combines), None)

    @property
    def readings(self) -> FinishedStudy | None:
        """The first study that sets a few readings of the experiment side by side."""
        return next((study for study in self.studies if not study.combines), None)

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
    def cells(self) -> list[Cell]:
        """The cells of the grid."""
        return cells(self.experiment, self.profiles)

    @cached_property
    def courses(self) -> Mapping[tuple[str, int, str], Sequence[Course]]:
        """Every run lived through again, by condition, number of cycles and policy."""
        return courses(self.cells, self.results, self.folder)

    @cached_property
    def regret(self) -> pd.DataFrame | None:
        """Regret by cell, where it was measured."""
        if self.results.regret is None:
            return None
        return regret_table(self.results.trials.merge(self.results.regret))

    @property
    def claims_file(self) -> Path:
        """Where claims about the experiment lie: beside its file, `<its name>_claims.yaml`."""
        return self.file.with_name(f"{self.file.stem}_claims.yaml")

    @cached_property
    def claims_about_all(self) -> Claims | None:
        """The claims of the claims file, if there is one. Raises ClaimsError if they are about another experiment."""
        if not self.claims_file.exists():
            return None
        loaded = load_claims(self.claims_file)
        if loaded.experiment_file.resolve() != self.file.resolve():
            raise ClaimsError(
                f"{self.claims_file}: experiment: is {loaded.experiment_file}; should be {self.file.name}."
            )
        return loaded

    @cached_property
    def claims(self) -> Evaluation | None:
        """The claims that are about no more than this grid, judged by the tables, where there are any."""
        about = {} if self.claims_about_all is None else self.claims_about_all.about(self.experiment.benchmark)
        if not about:
            return None
        results = self.results
        return evaluate(about, results.trials, results.contrasts, self.experiment.statistics, results.bounds)

    @property
    def claims_left_out(self) -> int:
        """How many claims are about more than this grid."""
        if self.claims_about_all is None:
            return 0
        return len(self.claims_about_all.claims) - len(self.claims_about_all.about(self.experiment.benchmark))

"""The cells that a study runs, and its tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.selection import cells
from fatigue_planner.study.benchmark.tables import ACTIONS, TIMES, trial_table
from fatigue_planner.study.benchmark.trial import TrialResult
from fatigue_planner.study.sensitivity.conclusions import conclusions
from fatigue_planner.study.sensitivity.factors import level_text
from fatigue_planner.study.sensitivity.gains import VerdictsOf, claim_table, gain_table, leader_table
from fatigue_planner.study.sensitivity.importance import importance_table
from fatigue_planner.study.sensitivity.reactions import Reacted
from fatigue_planner.study.sensitivity.study import Study


class StudyGrid:
    """The cells of all points that can be performed.

    cells: every different cell once; of_point: by point, in the grid's order, the indices of its cells.
    """

    def __init__(self, reacted: Sequence[Reacted]) -> None:
        indices: dict[str, int] = {}
        self.cells: list[Cell] = []
        self.of_point: dict[str, list[int]] = {}
        for result in reacted:
            if result.point.experiment is None or result.profiles is None:
                continue
            own = cells(result.point.experiment, result.profiles)
            for cell in own:
                digest = cell.digest()
                if digest not in indices:
                    indices[digest] = len(self.cells)
                    self.cells.append(cell)
                self.of_point.setdefault(result.point.name, []).append(indices[digest])

    def tables(self, results: Sequence[dict[int, TrialResult]]) -> Mapping[str, pd.DataFrame]:
        """The trials of every point, as `benchmark.tables.trial_table` without times, from the results of the cells."""
        tables = {
            point: trial_table([self.cells[index] for index in indices], [results[index] for index in indices])
            for point, indices in self.of_point.items()
        }
        return {point: table.drop(columns=[ACTIONS, *TIMES]) for point, table in tables.items()}


@dataclass(frozen=True)
class StudyTables:
    """The results of a study; each table is described where it is made.

    factors: one row per factor: its levels, the base experiment's own, and the reason for them.
    points: one row per point: its design, whether it is feasible, the reason if not, and its level of every factor.
    claims: None if the claims were not judged.
    """

    factors: pd.DataFrame
    points: pd.DataFrame
    gains: pd.DataFrame
    leaders: pd.DataFrame
    importance: pd.DataFrame
    claims: pd.DataFrame | None
    conclusions: list[str]

    def files(self) -> dict[str, pd.DataFrame]:
        """The tables by the names of their files."""
        tables = {"factors": self.factors, "points": self.points, "gains": self.gains}
        tables |= {"leaders": self.leaders, "importance": self.importance}
        return tables if self.claims is None else tables | {"claims_over_points": self.claims}


def study_tables(
    study: Study,
    reacted: Sequence[Reacted],
    trials: Mapping[str, pd.DataFrame],
    verdicts_of: VerdictsOf | None,
) -> StudyTables:
    """All tables and sentences from the trials of every point; `verdicts_of` judges the paper's claims at a point."""
    settings = study.settings
    points = [result.point for result in reacted]
    gains = gain_table(trials, settings.planners, settings.baselines)
    leaders = leader_table(trials)
    importance = importance_table(points, gains, settings.factors, settings.space_filling.seed)
    claims = None if verdicts_of is None else claim_table(trials, verdicts_of)
    sentences = conclusions(settings, points, gains, importance, leaders, claims, study.base.statistics)
    return StudyTables(_factor_table(study), _point_table(reacted), gains, leaders, importance, claims, sentences)


def _factor_table(study: Study) -> pd.DataFrame:
    base = study.base_levels()
    return pd.DataFrame(
        {
            "factor": name,
            "levels": ", ".join(map(level_text, factor.all_levels())),
            "base": level_text(base[name]),
            "reason": factor.reason,
        }
        for name, factor in study.settings.factors.items()
    )


def _point_table(reacted: Sequence[Reacted]) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "point": result.point.name,
            "design": result.point.design,
            "factor": result.point.factor,
            "feasible": result.profiles is not None,
            **result.point.levels,
            "reason": result.reason,
        }
        for result in reacted
    )

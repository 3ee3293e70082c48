"""The cells that a study runs, and its tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import pandas as pd

from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.selection import cells
from fatigue_planner.study.benchmark.tables import ACTIONS, TIMES, trial_table
from fatigue_planner.study.benchmark.trial import TrialResult
from fatigue_planner.study.sensitivity.agreement import agreement, agreement_sentences
from fatigue_planner.study.sensitivity.conclusions import conclusions
from fatigue_planner.study.sensitivity.design import Point
from fatigue_planner.study.sensitivity.factors import level_text
from fatigue_planner.study.sensitivity.gains import VerdictsOf, claim_table, gain_table, leader_table, verdict_table
from fatigue_planner.study.sensitivity.importance import importance_table
from fatigue_planner.study.sensitivity.reactions import Reacted
from fatigue_planner.study.sensitivity.settings import StudySettings
from fatigue_planner.study.sensitivity.shares import SHARES, cost_shares
from fatigue_planner.study.sensitivity.study import Study


class StudyRuns(NamedTuple):
    """What the runs of a study gave.

    trials: of every point, as `benchmark.tables.trial_table` without actions and times; shares: of the first baseline's
    cost, by point and joint (`shares.SHARES`), of a study without combinations.
    """

    trials: Mapping[str, pd.DataFrame]
    shares: pd.DataFrame


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

    def runs(self, results: Sequence[dict[int, TrialResult]], study: StudySettings) -> StudyRuns:
        """What the results of the cells say of every point."""
        tables = {
            point: trial_table([self.cells[index] for index in indices], [results[index] for index in indices])
            for point, indices in self.of_point.items()
        }
        trials = {point: table.drop(columns=[ACTIONS, *TIMES]) for point, table in tables.items()}
        wanted = (study.headline.condition, study.headline.n_cycles, study.baselines[0])
        shares = [
            (point, joint, share)
            for point, indices in self.of_point.items()
            for index in indices
            for cell in [self.cells[index]]
            if study.space_filling is None and (cell.condition, cell.n_cycles, cell.policy) == wanted
            for joint, share in cost_shares(cell, results[index]).items()
        ]
        return StudyRuns(trials, pd.DataFrame(shares, columns=SHARES))


@dataclass(frozen=True)
class StudyTables:
    """The results of a study; each table is described where it is made.

    factors: one row per factor: its levels, the base experiment's own, and the reason for them.
    points: one row per point: its design, whether it is feasible, the reason if not, its level of every factor, and,
        where one factor differs or there is only one, the argument for its level.
    claims, verdicts: None if the claims were not judged. importance: None without combinations; agreement, shares: None
        with them.
    """

    factors: pd.DataFrame
    points: pd.DataFrame
    gains: pd.DataFrame
    leaders: pd.DataFrame
    claims: pd.DataFrame | None
    verdicts: pd.DataFrame | None
    importance: pd.DataFrame | None
    agreement: pd.DataFrame | None
    shares: pd.DataFrame | None
    conclusions: list[str]

    def files(self) -> dict[str, pd.DataFrame]:
        """The tables by the names of their files."""
        tables = {
            "factors": self.factors, "points": self.points, "gains": self.gains, "leaders": self.leaders,
            "importance": self.importance, "claims_over_points": self.claims, "verdicts": self.verdicts,
            "agreement": self.agreement, "cost_shares": self.shares,
        }  # fmt: skip
        return {name: table for name, table in tables.items() if table is not None}


def study_tables(
    study: Study,
    reacted: Sequence[Reacted],
    runs: StudyRuns,
    verdicts_of: VerdictsOf | None,
) -> StudyTables:
    """All tables and sentences from the runs of every point; `verdicts_of` judges the paper's claims at a point."""
    settings, (trials, shares) = study.settings, runs
    points = [result.point for result in reacted]
    gains = gain_table(trials, settings.planners, settings.baselines)
    leaders = leader_table(trials)
    verdicts = None if verdicts_of is None else verdict_table(trials, verdicts_of)
    claims = None if verdicts is None else claim_table(verdicts)
    common = (_factor_table(study), _point_table(study, reacted), gains, leaders, claims, verdicts)
    if settings.space_filling is None:
        agreed = agreement(settings, gains, verdicts)
        sentences = agreement_sentences(settings, agreed, gains, shares, _levels(settings, points))
        return StudyTables(*common, None, agreed, shares, sentences)
    importance = importance_table(points, gains, settings.factors, settings.space_filling.seed)
    sentences = conclusions(settings, points, gains, importance, leaders, claims, study.base.statistics)
    return StudyTables(*common, importance, None, None, sentences)


def _levels(settings: StudySettings, points: Sequence[Point]) -> dict[str, str]:
    """The points by the level of the factor that differs; the base by that of the first factor."""
    first = next(iter(settings.factors))
    return {point.name: level_text(point.levels[point.factor or first]) for point in points}


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


def _point_table(study: Study, reacted: Sequence[Reacted]) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "point": result.point.name,
            "design": result.point.design,
            "factor": result.point.factor,
            "feasible": result.profiles is not None,
            **result.point.levels,
            "argument": _argument(study, result.point),
            "reason": result.reason,
        }
        for result in reacted
    )


def _argument(study: Study, point: Point) -> str:
    """The argument for the level of the factor that differs, or of the only factor."""
    factors = study.settings.factors
    name = point.factor or (next(iter(factors)) if len(factors) == 1 else "")
    return factors[name].argument(point.levels[name]) if name else ""

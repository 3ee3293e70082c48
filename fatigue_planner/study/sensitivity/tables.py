"""The tables of a study."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from fatigue_planner.study.sensitivity.conclusions import conclusions
from fatigue_planner.study.sensitivity.factors import level_text
from fatigue_planner.study.sensitivity.gains import gain_table, leader_table
from fatigue_planner.study.sensitivity.importance import importance_table
from fatigue_planner.study.sensitivity.reactions import Reacted
from fatigue_planner.study.sensitivity.robustness import VerdictsOf, claim_table
from fatigue_planner.study.sensitivity.study import Study


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

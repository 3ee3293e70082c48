"""What the runs of a benchmark make of claims: pure functions of tables."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.claims.analyses.modern import ModernAnalysis
from fatigue_planner.study.claims.analyses.paper import PaperAnalysis
from fatigue_planner.study.claims.answers import Verdict
from fatigue_planner.study.claims.headroom import Rooms
from fatigue_planner.study.claims.measurements import Measurements
from fatigue_planner.study.claims.relations.registry import RELATIONS
from fatigue_planner.study.claims.relations.relation import Finding
from fatigue_planner.study.claims.schema import Claim
from fatigue_planner.study.claims.tables import claims_table, detail_table
from fatigue_planner.study.statistics.contrasts import contrasts

# No verdict rests on a resampled number, so that the fewest are enough.
FEWEST_RESAMPLES = 99


@dataclass(frozen=True)
class Evaluation:
    """One row per claim, and one per comparison a claim consists of (`tables`)."""

    claims: pd.DataFrame
    detail: pd.DataFrame


def evaluate(
    claims: Mapping[str, Claim],
    trials: pd.DataFrame,
    settings: StatisticsSettings,
    seed: int,
    bounds: pd.DataFrame | None = None,
) -> Evaluation:
    """All there is to say of the claims.

    trials: the table of a benchmark; bounds: the costs no policy can beat (columns condition, n_cycles, cost_bound).
    """
    few = settings.model_copy(update={"resamples": FEWEST_RESAMPLES})
    measurements = Measurements(trials, contrasts(trials, few, seed))
    findings = _findings(claims, measurements, settings)
    rooms = None if bounds is None else Rooms(bounds, measurements, settings)
    return Evaluation(claims_table(claims, findings, measurements, rooms), detail_table(findings, measurements, rooms))


def verdicts(
    claims: Mapping[str, Claim], trials: pd.DataFrame, contrasts_table: pd.DataFrame, settings: StatisticsSettings
) -> dict[str, Verdict]:
    """The verdicts alone, by claim, from contrasts made already (of the same trials and settings): milliseconds."""
    findings = _findings(claims, Measurements(trials, contrasts_table), settings)
    return {name: Verdict(paper.answer, modern.answer) for name, (paper, modern) in findings.items()}


def _findings(
    claims: Mapping[str, Claim], measurements: Measurements, settings: StatisticsSettings
) -> dict[str, tuple[Finding, Finding]]:
    paper, modern = PaperAnalysis(measurements, settings), ModernAnalysis(measurements, settings)
    return {
        name: (RELATIONS[claim.relation].judge(claim, paper), RELATIONS[claim.relation].judge(claim, modern))
        for name, claim in claims.items()
    }

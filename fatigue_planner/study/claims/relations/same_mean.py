"""A, B and C have the same mean."""

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import RegretJob
from fatigue_planner.study.claims.measurements import Comparison
from fatigue_planner.study.claims.relations.relation import AmongEachOther


class SameMean(AmongEachOther):
    """Every two of `policies` have the same mean."""

    def ask(self, analysis: Analysis, comparison: Comparison) -> RegretJob:
        """The question."""
        return analysis.same_mean(comparison)

"""A, B and C are not significantly different from one another."""

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import RegretJob
from fatigue_planner.study.claims.measurements import Comparison
from fatigue_planner.study.claims.relations.relation import AmongEachOther


class NotSignificantlyDifferent(AmongEachOther):
    """No two of `policies` differ significantly."""

    def ask(self, analysis: Analysis, comparison: Comparison) -> RegretJob:
        """The question."""
        return analysis.not_different(comparison)

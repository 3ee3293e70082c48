"""A, B and C have the same mean."""

from fatigue_planner.claims.analyses.analysis import Analysis
from fatigue_planner.claims.answers import Judgement
from fatigue_planner.claims.measurements import Comparison
from fatigue_planner.claims.relations.relation import AmongEachOther


class SameMean(AmongEachOther):
    """Every two of `policies` have the same mean."""

    def ask(self, analysis: Analysis, comparison: Comparison) -> Judgement:
        """The question."""
        return analysis.same_mean(comparison)

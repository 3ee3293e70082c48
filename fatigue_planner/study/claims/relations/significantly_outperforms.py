"""A and B significantly outperform C and D."""

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import RegretJob
from fatigue_planner.study.claims.measurements import Comparison
from fatigue_planner.study.claims.relations.relation import EachOverEach


class SignificantlyOutperforms(EachOverEach):
    """Each of `policies` is significantly better than each of `others`."""

    def ask(self, analysis: Analysis, comparison: Comparison) -> RegretJob:
        """The question."""
        return analysis.significantly_better(comparison)

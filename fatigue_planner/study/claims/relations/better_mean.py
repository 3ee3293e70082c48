"""A and B are better than C and D; A is followed by B: rankings of means."""

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import RegretJob
from fatigue_planner.study.claims.measurements import Comparison
from fatigue_planner.study.claims.relations.relation import EachOverEach


class BetterMean(EachOverEach):
    """Each of `policies` is better than each of `others`."""

    def ask(self, analysis: Analysis, comparison: Comparison) -> RegretJob:
        """The question."""
        return analysis.better(comparison)

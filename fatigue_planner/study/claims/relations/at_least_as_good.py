"""A performs as well as B."""

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import RegretJob
from fatigue_planner.study.claims.measurements import Comparison
from fatigue_planner.study.claims.relations.relation import EachOverEach


class AtLeastAsGood(EachOverEach):
    """Each of `policies` is at least as good as each of `others`."""

    superiority = False

    def ask(self, analysis: Analysis, comparison: Comparison) -> RegretJob:
        """The question."""
        return analysis.at_least_as_good(comparison)

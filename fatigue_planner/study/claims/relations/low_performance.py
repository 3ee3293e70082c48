"""A shows low performance."""

from collections.abc import Sequence

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import RegretJob
from fatigue_planner.study.claims.measurements import Comparison
from fatigue_planner.study.claims.relations.relation import EachOverEach
from fatigue_planner.study.claims.schema import Claim


class LowPerformance(EachOverEach):
    """Each of `others` is better than each of `policies`."""

    def ask(self, analysis: Analysis, comparison: Comparison) -> RegretJob:
        """The question."""
        return analysis.better(comparison)

    def pairs(self, claim: Claim) -> Sequence[tuple[str, str]]:
        """The better one first."""
        return [(other, policy) for policy, other in super().pairs(claim)]

"""A, B and C have equivalent, or close, performance; A is shortly behind B."""

from collections.abc import Sequence

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import RegretJob
from fatigue_planner.study.claims.measurements import Comparison
from fatigue_planner.study.claims.relations.relation import AmongEachOther
from fatigue_planner.study.claims.schema import Claim


class Equivalent(AmongEachOther):
    """Every two of `policies` perform alike; with `others`, each of the ones and each of the others."""

    def ask(self, analysis: Analysis, comparison: Comparison) -> RegretJob:
        """The question."""
        return analysis.equivalent(comparison)

    def fault(self, claim: Claim) -> str:
        """Others may be given."""
        return "" if claim.others else super().fault(claim)

    def pairs(self, claim: Claim) -> Sequence[tuple[str, str]]:
        """Between the groups, if there are two."""
        if not claim.others:
            return super().pairs(claim)
        return [(policy, other) for policy in claim.policies for other in claim.others]

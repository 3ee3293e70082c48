"""No one best version can be concluded on."""

from itertools import permutations

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import Answer, RegretJob
from fatigue_planner.study.claims.measurements import Comparison, Pair
from fatigue_planner.study.claims.relations.relation import Finding, Part, Relation, judged, told
from fatigue_planner.study.claims.schema import Claim


class NoSingleBest(Relation):
    """None of `policies` is nowhere significantly worse than another one and somewhere significantly better than each.

    It is about what the runs show, so a difference that is not shown counts as none; undetermined only without runs.
    """

    superiority = False

    def fault(self, claim: Claim) -> str:
        """It takes one group."""
        if claim.others:
            return "takes no others"
        return "" if len(claim.policies) > 1 else "needs at least two policies"

    def judge(self, claim: Claim, analysis: Analysis) -> Finding:
        """Parts: every ordered pair, whether the first is significantly better."""
        parts = tuple(
            judged(Pair(*place, *pair), analysis, _significantly_better)
            for place in claim.places()
            for pair in permutations(claim.policies, 2)
        )
        unmeasured = tuple(part for part in parts if not part.judgement.measured)
        if unmeasured:
            reason = f"{told(unmeasured[0].pair)}: {unmeasured[0].judgement.reason}"
            return Finding(Answer.OPEN, reason, parts, unmeasured)
        shown = [part for part in parts if part.judgement.answer is Answer.HOLDS]
        for policy in claim.policies:
            wins = tuple(part for part in shown if part.pair.first == policy)
            if not _losses(policy, shown) and _beaten(wins) == set(claim.policies) - {policy}:
                reason = f"{policy} is nowhere significantly worse than another one and somewhere better than each"
                return Finding(Answer.FAILS, reason, parts, wins)
        against = [_why_not(policy, claim, shown) for policy in claim.policies]
        return Finding(Answer.HOLDS, "; ".join(against), parts, tuple(shown))


def _significantly_better(analysis: Analysis, comparison: Comparison) -> RegretJob:
    return analysis.significantly_better(comparison)


def _losses(policy: str, shown: list[Part]) -> list[Part]:
    return [part for part in shown if part.pair.second == policy]


def _beaten(wins: tuple[Part, ...]) -> set[str]:
    return {part.pair.second for part in wins}


def _why_not(policy: str, claim: Claim, shown: list[Part]) -> str:
    losses = _losses(policy, shown)
    if losses:
        pair = losses[0].pair
        return f"{policy} is beaten by {pair.first} ({pair.condition}, {pair.n_cycles} cycles)"
    beaten = _beaten(tuple(part for part in shown if part.pair.first == policy))
    unbeaten = [other for other in claim.policies if other not in {policy, *beaten}]
    return f"{policy} is nowhere shown to be better than {', '.join(unbeaten)}"

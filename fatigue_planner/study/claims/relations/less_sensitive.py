"""A is less sensitive to a setting than B: two settings of A differ less than the same two of B."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import Answer, RegretJob
from fatigue_planner.study.claims.measurements import Pair
from fatigue_planner.study.claims.relations.relation import Finding, Part, Relation, told, usable
from fatigue_planner.study.claims.schema import Claim

Range = tuple[float, float]


class LessSensitive(Relation):
    """The two `policies` differ less than the two `others`, averaged over all conditions and lengths."""

    superiority = False

    def fault(self, claim: Claim) -> str:
        """It takes two pairs."""
        return "" if len(claim.policies) == len(claim.others) == 2 else "needs two policies and two others"

    def judge(self, claim: Claim, analysis: Analysis) -> Finding:
        """Parts: both pairs in every condition and length, each with the size of its difference."""
        sizes: list[tuple[Range, Range]] = []
        parts: list[Part] = []
        for place in claim.places():
            pairs = [Pair(*place, *group) for group in (claim.policies, claim.others)]
            found = [usable(pair, analysis) for pair in pairs]
            reasons = [one if isinstance(one, str) else "" for one in found]
            if any(reasons):
                answer = Answer.OPEN
            else:
                ours, theirs = (analysis.size(one) for one in found if not isinstance(one, str))
                answer, _ = _compare(ours, theirs, analysis.margin)
                reasons = [f"differ by {_told(size)} of the cost" for size in (ours, theirs)]
                sizes.append((ours, theirs))
            parts += [
                Part(pair, RegretJob(answer, reason, measured=not isinstance(one, str)))
                for pair, one, reason in zip(pairs, found, reasons, strict=True)
            ]
        unmeasured = tuple(part for part in parts if not part.judgement.measured)
        if unmeasured:
            reason = f"{told(unmeasured[0].pair)}: {unmeasured[0].judgement.reason}"
            return Finding(Answer.OPEN, reason, tuple(parts), unmeasured)
        mean_ours, mean_theirs = (_range(ends) for ends in np.array(sizes).mean(axis=0))
        answer, words = _compare(mean_ours, mean_theirs, analysis.margin)
        reason = f"mean size of the difference {_told(mean_ours)} of the cost against {_told(mean_theirs)}: {words}"
        return Finding(answer, reason, tuple(parts), tuple(parts))


def _range(ends: NDArray[np.float64]) -> Range:
    return float(ends[0]), float(ends[1])


def _compare(ours: Range, theirs: Range, margin: float) -> tuple[Answer, str]:
    if ours[1] < theirs[0]:
        return Answer.HOLDS, "less"
    if ours[0] >= theirs[1]:
        return Answer.FAILS, "not less"
    if theirs[1] - ours[0] < margin:
        return Answer.FAILS, "less by no more than the margin, if at all"
    return Answer.OPEN, "the intervals overlap"


def _told(ends: Range) -> str:
    least, largest = (f"{100 * end:.2f}" for end in ends)
    return f"{least} %" if least == largest else f"{least} to {largest} %"

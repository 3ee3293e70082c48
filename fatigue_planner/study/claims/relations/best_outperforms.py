"""Our approach outperforms B, where the approach has several versions: the best of them does."""

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import Answer, RegretJob, all_of, any_of
from fatigue_planner.study.claims.measurements import Comparison, Pair
from fatigue_planner.study.claims.relations.relation import Finding, Part, Relation, judged, strongest_first, told
from fatigue_planner.study.claims.schema import Claim

WORDS = {Answer.HOLDS: "one wins", Answer.FAILS: "none wins", Answer.OPEN: "whether one wins is undetermined"}


class BestOutperforms(Relation):
    """In every condition and length there is one of `policies` that is better than each of `others`.

    Which one is not chosen beforehand by its mean, which would favour the luckiest: its own comparisons must hold.
    """

    superiority = True

    def fault(self, claim: Claim) -> str:
        """It takes two groups."""
        return "" if claim.others else "needs others"

    def judge(self, claim: Claim, analysis: Analysis) -> Finding:
        """All of the conditions and lengths; in each, any of the policies; of it, all comparisons."""
        parts: list[Part] = []
        nearest: list[Part] = []  # of every condition and length, the hardest comparison of the version nearest to it
        answers = []
        for place in claim.places():
            of_policies = [
                [judged(Pair(*place, policy, other), analysis, _better) for other in claim.others]
                for policy in claim.policies
            ]
            answer = any_of(_whole(own) for own in of_policies)
            hardest = [strongest_first(_deciding(own, answer))[0] for own in of_policies if _whole(own) is answer]
            nearest.append(min(hardest, key=lambda part: part.judgement.against))
            answers.append(answer)
            parts += [part for own in of_policies for part in own]
        answer = all_of(answers)
        decisive = strongest_first([part for part, one in zip(nearest, answers, strict=True) if one is answer])
        strongest = f"{told(decisive[0].pair)}: {decisive[0].judgement.reason}"
        reason = (
            f"{WORDS[answer]} in {len(decisive)} of {len(nearest)} conditions and lengths; the nearest, {strongest}"
        )
        return Finding(answer, reason, tuple(parts), decisive)


def _better(analysis: Analysis, comparison: Comparison) -> RegretJob:
    return analysis.better(comparison)


def _whole(parts: list[Part]) -> Answer:
    return all_of(part.judgement.answer for part in parts)


def _deciding(parts: list[Part], answer: Answer) -> list[Part]:
    return [part for part in parts if part.judgement.answer is answer]

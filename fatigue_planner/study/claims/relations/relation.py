"""What a claim may say of policies."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from itertools import combinations
from typing import ClassVar

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import Answer, RegretJob, all_of
from fatigue_planner.study.claims.measurements import Comparison, Pair
from fatigue_planner.study.claims.schema import Claim


@dataclass(frozen=True)
class Part:
    """A comparison a claim consists of, and what an analysis says of it."""

    pair: Pair
    judgement: RegretJob


@dataclass(frozen=True)
class Finding:
    """What an analysis says of a claim: answer, reason, all its parts, and those that decide, the strongest first."""

    answer: Answer
    reason: str
    parts: tuple[Part, ...]
    decisive: tuple[Part, ...]


class Relation(ABC):
    """A kind of statement. Its parts are the same, in the same order, for every analysis.

    superiority: whether a part says that its first policy is better, so that it matters how much could be won.
    """

    superiority: ClassVar[bool]

    @abstractmethod
    def fault(self, claim: Claim) -> str:
        """What is wrong with a claim of this kind, as in 'needs ...'; empty if nothing is."""

    @abstractmethod
    def judge(self, claim: Claim, analysis: Analysis) -> Finding:
        """What an analysis says of a claim."""


class PairwiseRelation(Relation):
    """One question, asked of some pairs in every condition and length; all must hold."""

    @abstractmethod
    def pairs(self, claim: Claim) -> Sequence[tuple[str, str]]:
        """The pairs of policies."""

    @abstractmethod
    def ask(self, analysis: Analysis, comparison: Comparison) -> RegretJob:
        """The question."""

    def judge(self, claim: Claim, analysis: Analysis) -> Finding:
        """All parts must hold."""
        parts = [
            judged(Pair(*place, *pair), analysis, self.ask) for place in claim.places() for pair in self.pairs(claim)
        ]
        answer = all_of(part.judgement.answer for part in parts)
        decisive = strongest_first([part for part in parts if part.judgement.answer is answer])
        return Finding(answer, counted(decisive, len(parts)), tuple(parts), decisive)


class EachOverEach(PairwiseRelation):
    """Each of `policies` and each of `others`."""

    superiority = True

    def fault(self, claim: Claim) -> str:
        """It takes two groups."""
        return "" if claim.others else "needs others"

    def pairs(self, claim: Claim) -> Sequence[tuple[str, str]]:
        """All of the one group with all of the other."""
        return [(policy, other) for policy in claim.policies for other in claim.others]


class AmongEachOther(PairwiseRelation):
    """Every pair of `policies`."""

    superiority = False

    def fault(self, claim: Claim) -> str:
        """It takes one group."""
        if claim.others:
            return "takes no others"
        return "" if len(claim.policies) > 1 else "needs at least two policies"

    def pairs(self, claim: Claim) -> Sequence[tuple[str, str]]:
        """Every pair once."""
        return list(combinations(claim.policies, 2))


def usable(pair: Pair, analysis: Analysis) -> Comparison | str:
    """The comparison of a pair, or why an analysis can conclude nothing from it."""
    comparison = analysis.measurements.compare(pair)
    return comparison if isinstance(comparison, str) else analysis.unusable(comparison) or comparison


def judged(pair: Pair, analysis: Analysis, ask: Callable[[Analysis, Comparison], RegretJob]) -> Part:
    """A pair and the answer to a question about it; undetermined, with the reason, where nothing can be concluded."""
    comparison = usable(pair, analysis)
    if isinstance(comparison, str):
        return Part(pair, RegretJob(Answer.OPEN, comparison, measured=False))
    return Part(pair, ask(analysis, comparison))


def strongest_first(parts: Sequence[Part]) -> tuple[Part, ...]:
    """The parts, that which speaks most against the claim first."""
    return tuple(sorted(parts, key=lambda part: (-part.judgement.against, astuple(part.pair))))


def counted(decisive: Sequence[Part], total: int) -> str:
    """How many of a claim's comparisons decide it, and the first of them in words."""
    strongest = f"{told(decisive[0].pair)}: {decisive[0].judgement.reason}"
    answer = decisive[0].judgement.answer
    if answer is Answer.HOLDS:
        return f"all hold; the closest is {strongest}" if total > 1 else strongest
    one = len(decisive) == 1
    words = f"{'is' if one else 'are'} undetermined" if answer is Answer.OPEN else "fails" if one else "fail"
    return f"{len(decisive)} of {total} {words}; {strongest}" if total > 1 else strongest


def told(pair: Pair) -> str:
    """A pair in words."""
    return f"{pair.first} against {pair.second} ({pair.condition}, {pair.n_cycles} cycles)"

"""What a claim may say of policies: a table of relations. To add one, write its function and a line in the table."""

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from functools import partial
from itertools import combinations, permutations

import numpy as np

from fatigue_planner.study.claims.analysis import Analysis, Reply
from fatigue_planner.study.claims.measurements import MeasuredPair
from fatigue_planner.study.claims.schema import Answer, Claim, all_of, any_of
from fatigue_planner.study.statistics.multiple_testing import Pair


@dataclass(frozen=True)
class PairJudgement:
    """What an analysis says of a comparison that a claim consists of.

    against: see `analysis.Reply`; measured: False where there are no usable runs.
    """

    pair: Pair
    answer: Answer
    reason: str
    against: float = 0.0
    measured: bool = True


@dataclass(frozen=True)
class ClaimJudgement:
    """What an analysis says of a claim: all its comparisons, and those that decide, the strongest first."""

    answer: Answer
    reason: str
    parts: Sequence[PairJudgement] = ()
    decisive: Sequence[PairJudgement] = ()


Question = Callable[[Analysis, MeasuredPair], Reply]
PairsOf = Callable[[Claim], Sequence[tuple[str, str]]]


@dataclass(frozen=True)
class Relation:
    """A kind of statement. The comparisons it consists of are the same, in the same order, for every analysis.

    fault: what is wrong with a claim of this kind, as in 'needs ...'; empty if nothing is
    judge: what an analysis says of a claim
    superiority: whether a comparison says that its first policy is better, so that it matters how much could be won
    """

    fault: Callable[[Claim], str]
    judge: Callable[[Claim, Analysis], ClaimJudgement]
    superiority: bool = False


# --- which policies are compared ---------------------------------------------------------------------------------


def _needs_others(claim: Claim) -> str:
    return "" if claim.others else "needs others"


def _takes_no_others(claim: Claim) -> str:
    if claim.others:
        return "takes no others"
    return "" if len(claim.policies) > 1 else "needs at least two policies"


def _others_or_several(claim: Claim) -> str:
    return "" if claim.others else _takes_no_others(claim)


def _needs_two_and_two(claim: Claim) -> str:
    return "" if len(claim.policies) == len(claim.others) == 2 else "needs two policies and two others"


def _between_the_groups(claim: Claim) -> Sequence[tuple[str, str]]:
    return [(policy, other) for policy in claim.policies for other in claim.others]


def _others_first(claim: Claim) -> Sequence[tuple[str, str]]:
    return [(other, policy) for policy, other in _between_the_groups(claim)]


def _among_each_other(claim: Claim) -> Sequence[tuple[str, str]]:
    return list(combinations(claim.policies, 2))


def _between_or_among(claim: Claim) -> Sequence[tuple[str, str]]:
    return _between_the_groups(claim) if claim.others else _among_each_other(claim)


# --- how a claim is judged ---------------------------------------------------------------------------------------


def _ask(analysis: Analysis, question: Question, pair: Pair) -> PairJudgement:
    measured = analysis.usable(pair)
    if isinstance(measured, str):
        return PairJudgement(pair, Answer.OPEN, measured, measured=False)
    return PairJudgement(pair, *question(analysis, measured))


def _all_pairs_hold(question: Question, pairs: PairsOf, claim: Claim, analysis: Analysis) -> ClaimJudgement:
    """A question, asked of some pairs in every condition and length; all must hold."""
    parts = [_ask(analysis, question, Pair(*cell, *names)) for cell in claim.cells() for names in pairs(claim)]
    answer = all_of(part.answer for part in parts)
    decisive = _strongest_first([part for part in parts if part.answer is answer])
    strongest = _told(decisive[0])
    if len(parts) == 1:
        reason = strongest
    elif answer is Answer.HOLDS:
        reason = f"all hold; the closest is {strongest}"
    else:
        single = len(decisive) == 1
        verb = f"{'is' if single else 'are'} undetermined" if answer is Answer.OPEN else "fails" if single else "fail"
        reason = f"{len(decisive)} of {len(parts)} {verb}; {strongest}"
    return ClaimJudgement(answer, reason, parts, decisive)


def _best_outperforms(claim: Claim, analysis: Analysis) -> ClaimJudgement:
    """In every condition and length there is one of `policies` that is better than each of `others`.

    Which one is not chosen beforehand by its mean, which would favour the luckiest: its own comparisons must hold.
    """
    parts: list[PairJudgement] = []
    nearest: list[PairJudgement] = []  # in every cell, the hardest comparison of the policy nearest to the claim
    answers = []
    for cell in claim.cells():
        of_policies = [
            [_ask(analysis, Analysis.better, Pair(*cell, policy, other)) for other in claim.others]
            for policy in claim.policies
        ]
        of_policy = [all_of(part.answer for part in own) for own in of_policies]
        answer = any_of(of_policy)
        hardest = [
            _strongest_first([part for part in own if part.answer is answer])[0]
            for own, answer_of_policy in zip(of_policies, of_policy, strict=True)
            if answer_of_policy is answer
        ]
        nearest.append(min(hardest, key=lambda part: part.against))
        answers.append(answer)
        parts += [part for own in of_policies for part in own]
    answer = all_of(answers)
    decisive = _strongest_first([part for part, own in zip(nearest, answers, strict=True) if own is answer])
    wins = {Answer.HOLDS: "one wins", Answer.FAILS: "none wins", Answer.OPEN: "whether one wins is undetermined"}
    reason = (
        f"{wins[answer]} in {len(decisive)} of {len(nearest)} conditions and lengths; the nearest, {_told(decisive[0])}"
    )
    return ClaimJudgement(answer, reason, parts, decisive)


def _less_sensitive(claim: Claim, analysis: Analysis) -> ClaimJudgement:
    """The two `policies` differ less than the two `others`, averaged over all conditions and lengths."""
    sizes: list[tuple[tuple[float, float], ...]] = []
    parts: list[PairJudgement] = []
    for cell in claim.cells():
        pairs = [Pair(*cell, *group) for group in (claim.policies, claim.others)]
        found = [analysis.usable(pair) for pair in pairs]
        answer, reasons = Answer.OPEN, [measured if isinstance(measured, str) else "" for measured in found]
        if not any(reasons):
            ours, theirs = (analysis.size(measured) for measured in found if not isinstance(measured, str))
            answer, _ = _smaller(ours, theirs, analysis.margin)
            reasons = [f"differ by {_size_told(*size)} of the cost" for size in (ours, theirs)]
            sizes.append((ours, theirs))
        parts += [
            PairJudgement(pair, answer, reason, measured=not isinstance(measured, str))
            for pair, measured, reason in zip(pairs, found, reasons, strict=True)
        ]
    if missing := _unmeasured(parts):
        return missing
    ours, theirs = ((float(least), float(largest)) for least, largest in np.array(sizes).mean(axis=0))
    answer, words = _smaller(ours, theirs, analysis.margin)
    reason = f"mean size of the difference {_size_told(*ours)} of the cost against {_size_told(*theirs)}: {words}"
    return ClaimJudgement(answer, reason, parts, parts)


def _smaller(ours: tuple[float, float], theirs: tuple[float, float], margin: float) -> tuple[Answer, str]:
    if ours[1] < theirs[0]:
        return Answer.HOLDS, "less"
    if ours[0] >= theirs[1]:
        return Answer.FAILS, "not less"
    if theirs[1] - ours[0] < margin:
        return Answer.FAILS, "less by no more than the margin, if at all"
    return Answer.OPEN, "the intervals overlap"


def _size_told(least: float, largest: float) -> str:
    low, high = f"{100 * least:.2f}", f"{100 * largest:.2f}"
    return f"{low} %" if low == high else f"{low} to {high} %"


def _no_single_best(claim: Claim, analysis: Analysis) -> ClaimJudgement:
    """None of `policies` is nowhere significantly worse than another one and somewhere significantly better than each.

    It is about what the runs show, so a difference that is not shown counts as none; undetermined only without runs.
    """
    parts = [
        _ask(analysis, Analysis.significantly_better, Pair(*cell, *names))
        for cell in claim.cells()
        for names in permutations(claim.policies, 2)
    ]
    if missing := _unmeasured(parts):
        return missing
    shown = [part for part in parts if part.answer is Answer.HOLDS]
    against = []
    for policy in claim.policies:
        losses = [part.pair for part in shown if part.pair.second == policy]
        wins = [part for part in shown if part.pair.first == policy]
        beaten = {policy, *(part.pair.second for part in wins)}
        unbeaten = [other for other in claim.policies if other not in beaten]
        if losses:
            cell = f"{losses[0].condition}, {losses[0].n_cycles} cycles"
            against.append(f"{policy} is beaten by {losses[0].first} ({cell})")
        elif unbeaten:
            against.append(f"{policy} is nowhere shown to be better than {', '.join(unbeaten)}")
        else:
            reason = f"{policy} is nowhere significantly worse than another one and somewhere better than each"
            return ClaimJudgement(Answer.FAILS, reason, parts, wins)
    return ClaimJudgement(Answer.HOLDS, "; ".join(against), parts, shown)


def _unmeasured(parts: Sequence[PairJudgement]) -> ClaimJudgement | None:
    """A claim that needs all its comparisons is undetermined if some were not measured; else None."""
    missing = [part for part in parts if not part.measured]
    return ClaimJudgement(Answer.OPEN, _told(missing[0]), parts, missing) if missing else None


def _strongest_first(parts: Sequence[PairJudgement]) -> list[PairJudgement]:
    """The comparisons, that which speaks most against the claim first."""
    return sorted(parts, key=lambda part: (-part.against, astuple(part.pair)))


def _told(part: PairJudgement) -> str:
    pair = part.pair
    return f"{pair.first} against {pair.second} ({pair.condition}, {pair.n_cycles} cycles): {part.reason}"


# --- the relations a file of claims can name ---------------------------------------------------------------------


def _all(question: Question, pairs: PairsOf) -> Callable[[Claim, Analysis], ClaimJudgement]:
    return partial(_all_pairs_hold, question, pairs)


RELATIONS = {
    # A and B significantly outperform C and D
    "significantly_outperforms": Relation(
        _needs_others, _all(Analysis.significantly_better, _between_the_groups), superiority=True
    ),
    # A and B are better than C and D; A is followed by B: rankings of means
    "better_mean": Relation(_needs_others, _all(Analysis.better, _between_the_groups), superiority=True),
    # A shows low performance: each of the others is better
    "low_performance": Relation(_needs_others, _all(Analysis.better, _others_first), superiority=True),
    # A, B and C are not significantly different from one another
    "not_significantly_different": Relation(_takes_no_others, _all(Analysis.not_different, _among_each_other)),
    # A, B and C have equivalent, or close, performance; A is shortly behind B
    "equivalent": Relation(_others_or_several, _all(Analysis.equivalent, _between_or_among)),
    # A, B and C have the same mean
    "same_mean": Relation(_takes_no_others, _all(Analysis.same_mean, _among_each_other)),
    # A performs as well as B
    "at_least_as_good": Relation(_needs_others, _all(Analysis.at_least_as_good, _between_the_groups)),
    # our approach outperforms B, where the approach has several versions: the best of them does
    "best_outperforms": Relation(_needs_others, _best_outperforms, superiority=True),
    # A is less sensitive to a setting than B: two settings of A differ less than the same two of B
    "less_sensitive": Relation(_needs_two_and_two, _less_sensitive),
    # no one best version can be concluded on
    "no_single_best": Relation(_takes_no_others, _no_single_best),
}

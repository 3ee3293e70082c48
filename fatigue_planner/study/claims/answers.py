"""Three-valued answers, Kleene's strong logic: what is undetermined stays so unless the rest decides."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class Answer(Enum):
    """Whether a statement holds."""

    HOLDS = "holds"
    FAILS = "fails"
    OPEN = "undetermined"

    @property
    def verdict(self) -> str:
        """What is said of a claim with this answer."""
        return {Answer.HOLDS: "reproduced", Answer.FAILS: "not reproduced", Answer.OPEN: "undetermined"}[self]


VERDICTS = tuple(answer.verdict for answer in Answer)


@dataclass(frozen=True)
class Verdict:
    """On a claim, by the paper's own analysis and by the modern one."""

    paper: Answer
    modern: Answer


def all_of(answers: Iterable[Answer]) -> Answer:
    """One that fails decides, else one that is open; holds for no answers."""
    given = set(answers)
    return next((answer for answer in (Answer.FAILS, Answer.OPEN) if answer in given), Answer.HOLDS)


def any_of(answers: Iterable[Answer]) -> Answer:
    """One that holds decides, else one that is open; fails for no answers."""
    given = set(answers)
    return next((answer for answer in (Answer.HOLDS, Answer.OPEN) if answer in given), Answer.FAILS)


@dataclass(frozen=True)
class RegretJob:
    """An answer and its reason in words.

    against: how much the difference speaks against the statement, as a share of the cost (negative: for it); of
        several that fail the largest is the strongest.
    measured: False where there are no usable runs.
    """

    answer: Answer
    reason: str
    against: float = 0.0
    measured: bool = True

"""Three-valued answers, Kleene's strong logic: what is undetermined stays so unless the rest decides."""

from collections.abc import Iterable
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


def all_of(answers: Iterable[Answer]) -> Answer:
    """Whether all hold: one that fails decides, else one that is open; holds for no answers."""
    given = set(answers)
    return next((answer for answer in (Answer.FAILS, Answer.OPEN) if answer in given), Answer.HOLDS)


def any_of(answers: Iterable[Answer]) -> Answer:
    """Whether any holds: one that holds decides, else one that is open; fails for no answers."""
    given = set(answers)
    return next((answer for answer in (Answer.HOLDS, Answer.OPEN) if answer in given), Answer.FAILS)

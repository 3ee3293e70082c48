"""The content of a file of claims, and what can be answered to one.

Answers have three values (Kleene's strong logic): what is undetermined stays so unless the rest decides.
"""

from collections.abc import Iterable
from enum import Enum
from typing import Annotated

from pydantic import Field

from fatigue_planner.core.settings import Name, Settings

Text = Annotated[str, Field(min_length=1)]


class Claim(Settings):
    """One statement of a paper and how it is read."""

    place: Text = Field(description="Where the statement is in the paper, e.g. its section.")
    quote: Text = Field(description="The statement, word for word.")
    interpretation: str = Field(default="", description="How it is read where its words leave that open.")
    conditions: tuple[Name, ...] = Field(
        min_length=1, description="The conditions it is about; it must hold in each of them."
    )
    n_cycles: tuple[int, ...] = Field(
        min_length=1, description="The numbers of cycles it is about; it must hold with each of them."
    )
    relation: str = Field(description="What is said of the policies: the name of a relation in docs/claims.md.")
    policies: tuple[Name, ...] = Field(min_length=1, description="The policies of which something is said.")
    others: tuple[Name, ...] = Field(
        default=(), description="The policies they are compared with, where the relation takes two groups."
    )

    def cells(self) -> list[tuple[str, int]]:
        """The conditions and lengths it is about."""
        return [(condition, n_cycles) for condition in self.conditions for n_cycles in self.n_cycles]


class ClaimsFile(Settings):
    """The claims of a paper by name."""

    experiment: Text = Field(
        max_length=1000,
        description="The experiment's file, relative to the folder of this file, or the name of one that ships.",
    )
    claims: dict[Name, Claim] = Field(min_length=1, description="The claims by name.")


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

"""The content of a file of claims."""

from typing import Annotated

from pydantic import Field

from fatigue_planner.core.settings import Name, Settings

Text = Annotated[str, Field(min_length=1)]


class Claim(Settings):
    """One statement of a paper and how it is read.

    place and quote: its section in the paper and its words; interpretation: how it is read, where that needs saying
    relation: what is said of `policies` and, where it takes two groups, `others` (`relations.RELATIONS`)
    conditions, n_cycles: it is said of every one of these conditions with every one of these lengths
    """

    place: Text
    quote: Text
    interpretation: str = ""
    conditions: tuple[Name, ...] = Field(min_length=1)
    n_cycles: tuple[int, ...] = Field(min_length=1)
    relation: str
    policies: tuple[Name, ...] = Field(min_length=1)
    others: tuple[Name, ...] = ()

    def cells(self) -> list[tuple[str, int]]:
        """The conditions and lengths it is about."""
        return [(condition, n_cycles) for condition in self.conditions for n_cycles in self.n_cycles]


class ClaimsFile(Settings):
    """The claims of a paper by name; `experiment`: the experiment's file, from the folder of this one."""

    experiment: Text = Field(max_length=1000)
    claims: dict[Name, Claim] = Field(min_length=1)

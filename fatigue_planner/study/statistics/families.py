"""Which comparisons a table of trials and the families of an experiment come to."""

from dataclasses import dataclass
from itertools import combinations

import pandas as pd

from fatigue_planner.experiment.statistics_settings import Family

CELL_AND_POLICY = ("condition", "n_cycles", "policy")
# The family of an experiment that names none: all pairs of policies in all conditions and lengths.
EVERYTHING = {"all": Family()}


@dataclass(frozen=True)
class Comparison:
    """Two policies in one cell of the grid; a difference is always first - second."""

    family: str
    condition: str
    n_cycles: int
    first: str
    second: str


def comparisons(trials: pd.DataFrame, families: dict[str, Family]) -> list[Comparison]:
    """The comparisons of all families, in the order of the families, cells and policies.

    `trials` has the columns condition, n_cycles and policy; a pair is ordered as its policies first appear there, or,
    in a family with `against`, by that. A pair stands once per family and cell, never a policy with itself. What a
    family names but the table lacks is left out: a command may have restricted the grid.
    """
    order = list(dict.fromkeys(trials["policy"]))
    cells: dict[tuple[str, int], set[str]] = {}
    for condition, n_cycles, policy in zip(*(trials[key].tolist() for key in CELL_AND_POLICY), strict=True):
        cells.setdefault((condition, n_cycles), set()).add(policy)
    return [
        Comparison(name, condition, n_cycles, first, second)
        for name, family in (families or EVERYTHING).items()
        for (condition, n_cycles), policies in cells.items()
        if _has(family.conditions, condition) and _has(family.n_cycles, n_cycles)
        for first, second in _pairs([policy for policy in order if policy in policies], family)
    ]


def _pairs(policies: list[str], family: Family) -> list[tuple[str, str]]:
    ours = [policy for policy in policies if _has(family.policies, policy)]
    if family.against is None:
        return list(combinations(ours, 2))
    pairs = [(one, other) for one in ours for other in policies if other in family.against and other != one]
    return [pair for place, pair in enumerate(pairs) if pair[::-1] not in pairs[:place]]


def _has(names: tuple[object, ...] | None, name: object) -> bool:
    return names is None or name in names

"""Families of comparisons, and the correction of their p-values for how many they are (Holm)."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from fatigue_planner.experiment.statistics_settings import Family

Vector = NDArray[np.float64]


def holm(p_values: Vector) -> Vector:
    """Holm's (1979) step-down correction (m,): the chance of any false rejection in the family stays below the level.

    NaN is no comparison: it stays NaN and does not count.
    """
    corrected = np.full(len(p_values), np.nan)
    there = np.flatnonzero(~np.isnan(p_values))
    order = there[np.argsort(p_values[there], kind="stable")]
    steps = np.arange(len(order), 0, -1)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(steps * p_values[order]))
    return corrected


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

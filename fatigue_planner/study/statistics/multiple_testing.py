"""Families of comparisons, and the correction of their p-values for how many they are (Holm)."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from fatigue_planner.experiment.statistics_settings import Family

Vector = NDArray[np.float64]


def holm(p_values: Vector) -> Vector:
    """Holm's (1979) step-down correction (m,): the chance of any false rejection in the family stays below the level.

    NaN is not a comparison: it stays NaN and does not count.
    """
    corrected = np.full(len(p_values), np.nan)
    tested = np.flatnonzero(~np.isnan(p_values))
    order = tested[np.argsort(p_values[tested], kind="stable")]
    steps = np.arange(len(order), 0, -1)
    corrected[order] = np.minimum(1.0, np.maximum.accumulate(steps * p_values[order]))
    return corrected


# The family of an experiment that names none: all pairs of policies in all conditions and lengths.
EVERYTHING = {"all": Family()}


@dataclass(frozen=True)
class Pair:
    """Two policies in a cell of the grid; a difference is always first - second."""

    condition: str
    n_cycles: int
    first: str
    second: str

    @property
    def cell(self) -> tuple[str, int]:
        """Condition and number of cycles."""
        return self.condition, self.n_cycles


def pairs_by_family(
    trials: pd.DataFrame, families: Mapping[str, Family], policies: Collection[str] | None = None
) -> list[tuple[str, Pair]]:
    """The pairs of all families, in the order of the families, cells and policies.

    `policies` are those of a family that names none; None: all.
    `trials` has the columns condition, n_cycles and policy; a pair is ordered as its policies first appear there, or,
    in a family with `against`, by that. A pair is in a family once per cell, never a policy with itself. What a
    family names but the table lacks is left out: a command may have restricted the grid.
    """
    order = list(dict.fromkeys(trials["policy"]))
    cells: dict[tuple[str, int], set[str]] = {}
    for condition, n_cycles, policy in zip(
        trials["condition"], trials["n_cycles"].tolist(), trials["policy"], strict=True
    ):
        cells.setdefault((condition, n_cycles), set()).add(policy)
    return [
        (name, Pair(*cell, first, second))
        for name, family in (families or EVERYTHING).items()
        for cell, there in cells.items()
        if _names(family.conditions, cell[0]) and _names(family.n_cycles, cell[1])
        for first, second in _pairs([policy for policy in order if policy in there], family, policies)
    ]


def _pairs(there: list[str], family: Family, usual: Collection[str] | None) -> list[tuple[str, str]]:
    own = [policy for policy in there if _names(usual if family.policies is None else family.policies, policy)]
    if family.against is None:
        return list(combinations(own, 2))
    pairs = [(first, second) for first in own for second in there if second in family.against and second != first]
    return [pair for index, pair in enumerate(pairs) if pair[::-1] not in pairs[:index]]


def _names(names: Collection[object] | None, name: object) -> bool:
    return names is None or name in names

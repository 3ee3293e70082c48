"""What is known of the difference between two policies in one cell of the grid."""

from dataclasses import dataclass, fields, replace
from enum import StrEnum
from math import nan
from typing import Self

import pandas as pd

from fatigue_planner.core.errors import UnknownContrastError
from fatigue_planner.study.statistics.pairing import records

# How the columns change when first and second are exchanged.
_OPPOSITE = ("difference", "relative_difference", "cohen_dz", "hedges_g")
_SWAPPED = (("first", "second"), ("first_mean", "second_mean"))
_MIRRORED = (("t_low", "t_high"), ("bca_low", "bca_high"))


class Verdict(StrEnum):
    """What a contrast says of its first policy."""

    BETTER = "better"
    WORSE = "worse"
    EQUIVALENT = "equivalent"
    UNDETERMINED = "undetermined"


@dataclass(frozen=True)
class Contrast:
    """One row of contrasts.csv; docs/statistics.md gives every column's formula and source.

    Returns and what is derived from them are costs with the sign turned; difference: mean of first - second, positive
    where the first is better. NaN is what cannot be said, and `note` says why.
    """

    family: str
    condition: str
    n_cycles: int
    first: str
    second: str
    trials: int = 0
    first_mean: float = nan
    second_mean: float = nan
    difference: float = nan
    relative_difference: float = nan
    standard_error: float = nan
    t_low: float = nan
    t_high: float = nan
    bca_low: float = nan
    bca_high: float = nan
    student_p: float = nan
    welch_p: float = nan
    paired_p: float = nan
    permutation_p: float = nan
    holm_p: float = nan
    cohen_dz: float = nan
    hedges_g: float = nan
    improvement: float = nan
    improvement_low: float = nan
    improvement_high: float = nan
    detectable_difference: float = nan
    equivalence_margin: float = nan
    equivalence_p: float = nan
    equivalent_within: float = nan
    note: str = ""

    @property
    def mean_cost(self) -> float:
        """The mean of the two policies' mean costs; NaN unless positive: else no fraction of it makes sense."""
        cost = -(self.first_mean + self.second_mean) / 2
        return cost if cost > 0 else nan

    def flipped(self) -> Self:
        """The same with first and second exchanged."""
        changes: dict[str, object] = {name: -getattr(self, name) for name in _OPPOSITE}
        changes |= {name: getattr(self, other) for pair in _SWAPPED for name, other in (pair, pair[::-1])}
        changes |= {name: -getattr(self, other) for pair in _MIRRORED for name, other in (pair, pair[::-1])}
        changes["improvement"] = 1 - self.improvement
        changes["improvement_low"] = 1 - self.improvement_high
        changes["improvement_high"] = 1 - self.improvement_low
        return replace(self, **changes)  # type: ignore[arg-type]

    def verdict(self, level: float) -> Verdict:
        """Better or worse by the paired test, corrected (Holm), at the level; else equivalent, by the test of that.

        Where nothing is left to chance the difference itself decides.
        """
        exact = self.standard_error == 0
        if self.holm_p < level or (exact and self.difference != 0):
            return Verdict.BETTER if self.difference > 0 else Verdict.WORSE
        return Verdict.EQUIVALENT if self.equivalence_p < level or exact else Verdict.UNDETERMINED


COLUMNS = [field.name for field in fields(Contrast)]


def contrasts_in(table: pd.DataFrame) -> list[Contrast]:
    """The rows of a table of contrasts."""
    return [Contrast(**row) for row in records(table)]


def is_compared(table: pd.DataFrame, condition: str, n_cycles: int, first: str, second: str) -> bool:
    """Whether a family has the contrast of two policies, in either order."""
    cell = table[(table["condition"] == condition) & (table["n_cycles"] == n_cycles)]
    pairs = set(zip(cell["first"], cell["second"], strict=True))
    return bool(pairs & {(first, second), (second, first)})


def contrast_of(table: pd.DataFrame, condition: str, n_cycles: int, first: str, second: str) -> Contrast:
    """The contrast of two policies, turned if the table holds it the other way round.

    `table` is `contrasts`'s. A pair of several families is taken from the first one: they differ in holm_p only.
    Raises UnknownContrastError if no family has it.
    """
    cell = table[(table["condition"] == condition) & (table["n_cycles"] == n_cycles)]
    for policy, other in ((first, second), (second, first)):
        rows = cell[(cell["first"] == policy) & (cell["second"] == other)]
        if len(rows):
            contrast = contrasts_in(rows.head(1))[0]
            return contrast if policy == first else contrast.flipped()
    raise UnknownContrastError(
        f"{first} against {second} in {condition}, {n_cycles} cycles: is in no family of the experiment's statistics."
    )

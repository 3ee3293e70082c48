"""What is known of the difference between two policies in one cell of the grid, and all of it in words."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from math import nan
from typing import Self

import pandas as pd

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
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


def contrast_of(table: pd.DataFrame, condition: str, n_cycles: int, first: str, second: str) -> Contrast | None:
    """The contrast of two policies, turned if the table holds it the other way round; None if no family compares them.

    `table` is `contrasts`'s. A pair of several families is taken from the first one: they differ in holm_p only.
    """
    cell = table[(table["condition"] == condition) & (table["n_cycles"] == n_cycles)]
    for policy, other in ((first, second), (second, first)):
        rows = cell[(cell["first"] == policy) & (cell["second"] == other)]
        if len(rows):
            contrast = contrasts_in(rows.head(1))[0]
            return contrast if policy == first else contrast.flipped()
    return None


NOT_DIFFERENT = (Verdict.EQUIVALENT, Verdict.UNDETERMINED)
MAX_LISTED = 15  # per family; all of them are in the table


def contrast_text(table: pd.DataFrame, settings: StatisticsSettings) -> str:
    """The table of `contrasts` in words. Fractions are of the mean cost of the two policies."""
    if table.empty:
        return "Contrasts: none; no family of the experiment compares two of these policies.\n"
    level = settings.significance_level
    lines = [
        "Contrasts: policies with common random numbers, by the paired t-test, corrected within each family (Holm) at "
        f"{100 * level:g} %;",
        f"equivalent: the costs differ by less than {100 * settings.equivalence_margin:g} % (TOST).",
    ]
    for name, rows in table.groupby("family", sort=False):
        lines += ["", *_family_lines(str(name), contrasts_in(rows), level)]
    return "\n".join(lines) + "\n"


def _family_lines(name: str, family: Sequence[Contrast], level: float) -> Iterator[str]:
    tested = [contrast for contrast in family if contrast.paired_p >= 0]
    verdicts = Counter(contrast.verdict(level) for contrast in tested)
    differ = verdicts[Verdict.BETTER] + verdicts[Verdict.WORSE]
    counts = f"{differ} differ, " + ", ".join(f"{verdicts[verdict]} {verdict}" for verdict in NOT_DIFFERENT)
    number = f"{len(family)} comparison{'s' if len(family) > 1 else ''}"
    yield f"{name}: {number}" + (f", {len(tested)} tested: {counts}" if tested else "")
    for note, count in Counter(contrast.note for contrast in family if contrast.note).items():
        yield f"  {count} {note}"
    otherwise = [contrast for contrast in tested if (contrast.student_p < level) != (contrast.holm_p < level)]
    otherwise = [contrast for contrast in otherwise if contrast.student_p >= 0]
    if otherwise:
        yield f"  The paper's test (Student's, unpaired, not corrected) says otherwise of {len(otherwise)}:"
        yield f"  (the better mean first; its gain as a fraction of the cost with its {100 * (1 - level):g} % interval)"
    for contrast in otherwise[:MAX_LISTED]:
        yield f"    {_sentence(contrast if contrast.difference > 0 else contrast.flipped(), level)}"
    if len(otherwise) > MAX_LISTED:
        yield f"    … and of {len(otherwise) - MAX_LISTED} more, see contrasts.csv"


def _sentence(contrast: Contrast, level: float) -> str:
    """How the better policy of the two compares with the other one."""
    low, middle, high = (
        100 * number / contrast.mean_cost for number in (contrast.t_low, contrast.difference, contrast.t_high)
    )
    return (
        f"{contrast.condition}, {contrast.n_cycles} cycles: {contrast.first} against {contrast.second} "
        f"{contrast.verdict(level)}, {middle:.2f} % [{low:.2f}, {high:.2f}] "
        f"(p = {contrast.holm_p:.2g}, the paper's {contrast.student_p:.2g})"
    )

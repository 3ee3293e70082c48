"""The contrasts in words: how many of each verdict, and where the paper's own test says otherwise."""

from collections import Counter
from collections.abc import Iterator, Sequence

import pandas as pd

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.statistics.contrast import Contrast, Verdict, contrasts_in

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

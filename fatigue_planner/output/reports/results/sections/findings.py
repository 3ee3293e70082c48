"""What one learns, at the top of the report."""

from collections import Counter

import pandas as pd

from fatigue_planner.core.text import counted, format_label, listing, percent, percent_range
from fatigue_planner.ergonomics.indicators.iso_11226 import arm_hold
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.results.sections.claims import claims_sentence
from fatigue_planner.output.reports.results.sections.losses import headroom
from fatigue_planner.output.reports.results.sections.postures import overhead_sentences
from fatigue_planner.output.reports.results.sections.worth import worth_sentences
from fatigue_planner.study.statistics.contrast import Contrast, Verdict, contrast_of
from fatigue_planner.study.statistics.pairing import cells_of, records


def findings(report_data: ReportData) -> list[str]:
    """A few sentences, each from the tables."""
    grid, trials = report_data.experiment.benchmark, report_data.results.trials
    items = [
        *worth_sentences(report_data),
        f"{counted(len(grid.policies), 'policy', 'policies')} in {counted(len(grid.conditions), 'condition')} over "
        f"{listing([str(n) for n in grid.n_cycles])} cycles: {counted(len(trials), 'run')}, seed {grid.seed}.",
        *overhead_sentences(report_data, {reaction.name: arm_hold(reaction) for reaction in report_data.reactions}),
        _leaders(report_data),
        *_against_the_anchor(report_data),
    ]
    if report_data.results.bounds is not None and len(report_data.results.bounds):
        items.append(_headroom_sentence(report_data, report_data.results.bounds))
    if report_data.claims is not None:
        items.append(claims_sentence(report_data.claims))
    if left_out := report_data.claims_left_out:
        file = report_data.claims_file.name
        items.append(f"{counted(left_out, 'claim')} of `{file}` not judged: about more than this grid.")
    if (readings := report_data.readings) is not None:
        items += readings.conclusions[:3]
    if (study := report_data.study) is not None:
        items.append(f"The study `{study.note.study.name}` of other settings: {study.conclusions[0]}")
    return items


def _leaders(report_data: ReportData) -> str:
    """Policies with the same mean all lead."""
    best: Counter[str] = Counter()
    cells = [cell for _, _, cell in cells_of(report_data.results.comparison)]
    for cell in cells:
        best.update(cell.loc[cell["mean"] == cell["mean"].max(), "policy"])
    (first, most), *others = best.most_common()
    return (
        f"`{first}` has the best mean in {most} of {counted(len(cells), 'cell')} (a condition and a number of cycles)"
        f"{''.join(f', `{policy}` in {count}' for policy, count in others)}."
    )


def _against_the_anchor(report_data: ReportData) -> list[str]:
    """For every condition the policy with the best mean in the longest runs, beside the anchor."""
    level, sentences = report_data.experiment.statistics.significance_level, []
    for condition, n_cycles, cell in cells_of(report_data.results.comparison):
        others = [row["policy"] for row in records(cell) if row["policy"] != report_data.anchor]
        if n_cycles != report_data.longest or not others:
            continue
        found = contrast_of(report_data.results.contrasts, condition, n_cycles, others[0], report_data.anchor)
        if found is None:
            continue
        sentences.append(
            f"{format_label(condition).capitalize()}, {n_cycles} cycles: the best policy other than "
            f"`{report_data.anchor}` is `{others[0]}`; its cost is {_difference(found, level)}."
        )
    return sentences


def _difference(found: Contrast, level: float) -> str:
    """By how much the first costs less or more than the second, of the second's cost."""
    if found.difference == 0:
        return "the same in every run" if not found.paired_p >= 0 else "the same"
    cost, side = -found.second_mean, "lower" if found.difference > 0 else "higher"
    share = f"{percent(abs(found.difference) / cost)} {side}"
    if found.standard_error == 0:
        return f"{share} (one deterministic run each)"
    if not found.paired_p >= 0:
        return f"{share} ({found.note})"
    sign = 1 if found.difference > 0 else -1
    low, high = sorted(sign * end / cost for end in (found.t_low, found.t_high))
    return f"{share}, with an interval of {percent_range(low, high)} ({_words(found, level)})"


def _words(found: Contrast, level: float) -> str:
    return {
        Verdict.BETTER: "a significant difference",
        Verdict.WORSE: "a significant difference",
        Verdict.EQUIVALENT: "equivalent within the margin",
        Verdict.UNDETERMINED: "undetermined",
    }[found.verdict(level)]


def _headroom_sentence(report_data: ReportData, gaps: pd.DataFrame) -> str:
    last = gaps[(gaps["n_cycles"] == report_data.longest) & (gaps["policy"] == report_data.anchor)]
    shares = [f"{headroom(row)} ({format_label(row['condition'])})" for row in records(last)]
    return (
        f"Over {report_data.longest} cycles the expected cost of any policy whatsoever is at most {listing(shares)} "
        f"below that of `{report_data.anchor}`. This bound is proved; ± is the standard error of the mean of "
        f"`{report_data.anchor}`."
    )

"""The returns: the paper's Figure 5, and the same runs as estimates of what each policy costs above one of them."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fatigue_planner.core.text import counted, format_label, listing, percent, percent_range, significant
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.output.figures.style import (
    FigureFolder,
    Picture,
    house_style,
    look,
    mark_policies,
    new_figure,
    set_title,
)
from fatigue_planner.output.reports.page import Block, Section, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.study.benchmark.results import CONTRASTS_FILE
from fatigue_planner.study.statistics.comparison import STARS
from fatigue_planner.study.statistics.contrast import Verdict, contrast_of, contrasts_in
from fatigue_planner.study.statistics.pairing import cells_of, records


def returns_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """Figure 5 as the paper draws it, and differences to one policy with paired intervals."""
    blocks: list[Block] = [*draw_returns(figures, report_data.experiment, report_data.results.comparison)]
    settings = report_data.experiment.statistics
    table = estimate_table(report_data.results.contrasts, report_data.results.trials, report_data.anchor)
    if len(table):
        level = percent(1 - settings.significance_level, 0)
        caption = (
            f"The same runs as estimates: the mean cost above that of `{report_data.anchor}` with the same random "
            f"numbers, as a fraction of its cost, with {level} intervals (paired t). Policies in the grey band count "
            f"as equivalent (±{percent(settings.equivalence_margin, 1)} of the cost, fixed beforehand)."
        )
        figure = estimate_figure(table, settings.equivalence_margin, report_data.policies)
        blocks.append(figures.add("estimates", figure, table, caption, _extremes(table)))
    blocks.append(Text(_counts(report_data, CONTRASTS_FILE)))
    return Section("Returns", blocks)


def draw_returns(figures: FigureFolder, experiment: Experiment, comparison: pd.DataFrame) -> list[Picture]:
    """The paper's Figure 5: one picture for each that the experiment names."""
    pictures = []
    for name, conditions in experiment.figures.items():
        shown = comparison[comparison["condition"].isin(conditions)]
        figure = returns_figure(comparison, conditions, list(experiment.benchmark.policies))
        caption = (
            f"`{name}`: discounted accumulated reward, mean ± standard deviation over the runs, the best policy first. "
            "The marks between neighbours are the paper's test: Student's, unpaired, not corrected "
            f"({', '.join(f'{mark} p < {limit:g}' for limit, mark in reversed(STARS))}, ns: p ≥ "
            f"{experiment.statistics.significance_level:g}; no mark where a policy has only one run)."
        )
        pictures.append(figures.add(name, figure, shown, caption, _best_and_worst(shown)))
    return pictures


def _best_and_worst(comparison: pd.DataFrame) -> str:
    sentences = []
    for condition, n_cycles, cell in cells_of(comparison):
        best, worst = records(cell.iloc[[0, -1]])
        sentences.append(
            f"{format_label(condition)}, {n_cycles} cycles: from {format_label(best['policy'])} "
            f"({significant(best['mean'])}) to {format_label(worst['policy'])} ({significant(worst['mean'])})"
        )
    return "; ".join(sentences) + "."


def _extremes(table: pd.DataFrame) -> str:
    sentences = []
    for condition, n_cycles, cell in cells_of(table):
        ends = records(cell.sort_values("extra_cost_share", kind="stable").iloc[[0, -1]])
        named = [
            f"{format_label(end['policy'])} at {percent(end['extra_cost_share'])}"
            + (f" ({percent_range(low, high)})" if low < high else "")
            for end in ends
            for low, high in [(end["low_share"], end["high_share"])]
        ]
        sentences.append(f"{format_label(condition)}, {n_cycles} cycles: from {named[0]} to {named[1]}")
    return "; ".join(sentences) + "."


def _counts(report_data: ReportData, file: str) -> str:
    """How the modern analysis and the paper's test count the comparisons."""
    level = report_data.experiment.statistics.significance_level
    rows = contrasts_in(report_data.results.contrasts)
    tested = [row for row in rows if row.paired_p >= 0]
    if not tested:
        return "No two policies could be tested against each other."
    counts = {verdict: sum(row.verdict(level) == verdict for row in tested) for verdict in Verdict}
    different = counts[Verdict.BETTER] + counts[Verdict.WORSE]
    both = [row for row in tested if row.student_p >= 0]
    papers = sum(row.student_p < level for row in both)
    families = list(dict.fromkeys(row.family for row in rows))
    return (
        f"Of {counted(len(rows), 'comparison')} in {counted(len(families), 'family', 'families')} "
        f"({listing(families)}), {len(tested)} can be tested. Paired and corrected for the family (Holm), "
        f"{different} show a difference, {counts[Verdict.EQUIVALENT]} equivalence and "
        f"{counts[Verdict.UNDETERMINED]} neither; the paper's test, which neither pairs nor corrects, "
        f"finds a difference in {papers} of {len(both)}. All numbers of every comparison (intervals by t and "
        f"bootstrap, permutation test, effect sizes, smallest detectable difference) are in `{file}`."
    )


@house_style()
def returns_figure(comparison: pd.DataFrame, conditions: Sequence[str], policies: Sequence[str]) -> Figure:
    """Panels of mean ± standard deviation: one row per condition, one column per number of cycles.

    `comparison` is the table of `statistics.comparison`; policies are in the order of their means,
    with the verdict of the test against the next one between them.
    """
    lengths = list(dict.fromkeys(comparison["n_cycles"]))
    figure = new_figure(3.3 * len(lengths) + 0.4, 2.9 * len(conditions))
    axes = figure.subplots(len(conditions), len(lengths), squeeze=False)
    for row, condition in enumerate(conditions):
        for column, n_cycles in enumerate(lengths):
            cell = comparison[(comparison["condition"] == condition) & (comparison["n_cycles"] == n_cycles)]
            _panel(axes[row, column], cell, list(policies))
            set_title(axes[row, column], f"{format_label(condition)}, $n_{{cycles}}$ = {n_cycles}")
        axes[row, 0].set_ylabel("discounted accumulated reward\n(mean ± standard deviation)")
    return figure


def _panel(axes: Axes, cell: pd.DataFrame, policies: list[str]) -> None:
    low = (cell["mean"] - cell["standard_deviation"]).min()
    high = (cell["mean"] + cell["standard_deviation"]).max()
    span = high - low or abs(high) or 1.0
    rows = cell.to_dict("records")
    for index, row in enumerate(rows):
        marker, colour = look(policies.index(row["policy"]))
        error = row["standard_deviation"] or None
        axes.errorbar(index, row["mean"], yerr=error, fmt=marker, color=colour, capsize=3, markersize=5)
    tops = [row["mean"] + row["standard_deviation"] for row in rows]
    for index, row in enumerate(rows[:-1]):
        if not np.isnan(row["p_value"]):
            height = max(tops[index : index + 2]) + (0.05 + 0.06 * (index % 2)) * span
            foot = height - 0.01 * span
            axes.plot([index, index, index + 1, index + 1], [foot, height, height, foot], color="0.3", linewidth=0.7)
            axes.text(index + 0.5, height, row["verdict"], ha="center", va="bottom", fontsize=7)
    axes.set_xticks(range(len(rows)), [format_label(row["policy"]) for row in rows], rotation=40, ha="right")
    axes.set_xlim(-0.6, len(rows) - 0.4)
    axes.set_ylim(low - 0.08 * span, high + 0.25 * span)
    axes.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))


def estimate_table(contrasts: pd.DataFrame, trials: pd.DataFrame, anchor: str) -> pd.DataFrame:
    """Cost of every policy minus the anchor's with the same random numbers, as a fraction of the anchor's.

    With its interval; positive: costs more than the anchor. Pairs that no family compares are left out.
    """
    rows = []
    for condition, n_cycles, cell in cells_of(trials):
        for policy in dict.fromkeys(cell["policy"]):
            found = contrast_of(contrasts, condition, n_cycles, policy, anchor)
            if found is None:
                continue
            cost = -found.second_mean or np.nan
            rows.append(
                {
                    "condition": condition, "n_cycles": n_cycles, "policy": policy, "anchor": anchor,
                    "extra_cost_share": -found.difference / cost, "low_share": -found.t_high / cost,
                    "high_share": -found.t_low / cost, "note": found.note,
                }
            )  # fmt: skip
    return pd.DataFrame(rows)


@house_style()
def estimate_figure(table: pd.DataFrame, margin: float, policies: Sequence[str]) -> Figure:
    """Panels of intervals: one row per condition, one column per number of cycles; the margin is shaded."""
    conditions, lengths = list(dict.fromkeys(table["condition"])), list(dict.fromkeys(table["n_cycles"]))
    shown = [policy for policy in policies if policy in set(table["policy"])]
    figure = new_figure(7.2, len(conditions) * (0.75 + 0.19 * len(shown)) + 0.4)
    axes = figure.subplots(len(conditions), len(lengths), squeeze=False, sharey=True)
    for row, condition in enumerate(conditions):
        for column, n_cycles in enumerate(lengths):
            cell = table[(table["condition"] == condition) & (table["n_cycles"] == n_cycles)].set_index("policy")
            axes[row, column].axvspan(-100 * margin, 100 * margin, color="0.9", zorder=0, linewidth=0)
            axes[row, column].axvline(0, color="0.4", linewidth=0.8)
            estimates = 100 * cell[["extra_cost_share", "low_share", "high_share"]].astype(float)
            marks = {
                str(policy): (centre, None if np.isnan(low) else [[centre - low], [high - centre]])
                for policy, centre, low, high in estimates.itertuples()
            }
            mark_policies(axes[row, column], shown, policies, marks)
            set_title(axes[row, column], f"{format_label(str(condition))}, {n_cycles} cycles")
    anchor = format_label(str(table["anchor"].iloc[0]))
    figure.supxlabel(f"cost above that of {anchor}, % of it (shaded: ±{100 * margin:g} %, equivalent)", fontsize=9)
    return figure

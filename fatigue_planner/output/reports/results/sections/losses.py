"""What the decisions lose against the exact reference, and the cost that no policy can beat."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label, listing, percent, significant
from fatigue_planner.output.figures.style import FigureFolder, house_style, mark_policies, new_figure, set_title
from fatigue_planner.output.reports.page import Block, Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.planners.lookahead import describe
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE
from fatigue_planner.study.statistics.pairing import cells_of, groups_of, records

WIDE = 2  # standard errors that a bar reaches to either side
HOW = "This was not measured; `fatplan benchmark --regret --bound` adds it."


def losses_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """Regret and bounds, or the command that makes them."""
    blocks: list[Block] = []
    if report_data.regret is None and report_data.results.bounds is None:
        blocks.append(Text(HOW))
    if report_data.regret is not None:
        blocks += _regret(report_data, figures)
    if report_data.results.bounds is not None and len(report_data.results.bounds):
        blocks += _bounds(report_data)
    return Section("Distance to the optimum", blocks)


def _regret(report_data: ReportData, figures: FigureFolder) -> list[Block]:
    table = report_data.regret
    assert table is not None
    judges = report_data.results.note.references
    named = [condition for condition in report_data.experiment.benchmark.conditions if condition in judges]
    references = [f"{format_label(condition)}: {describe(judges[condition])}" for condition in named]
    intro = (
        "Every decision of every run is judged by a reference that looks ahead exactly: "
        + "; ".join(references)
        + ". Regret is the reference's value of the best action minus that of the action taken, summed over a run with "
        "the task's discount. Like the policies, the reference plans for a task that never ends."
    )
    last = table[table["n_cycles"] == report_data.longest]
    sentences = [
        f"{format_label(condition)}: "
        + listing([f"{percent(row['run_loss_share'])} for {format_label(row['policy'])}" for row in records(cell)])
        for condition, cell in groups_of(last, "condition")
    ]
    figure = regret_figure(table, report_data.longest, report_data.policies)
    caption = "What the decisions of a run lose against the reference, as a fraction of the run's cost."
    return [Text(intro), figures.add("regret_by_policy", figure, table, caption, "; ".join(sentences) + ".")]


def _bounds(report_data: ReportData) -> list[Block]:
    gaps = report_data.results.bounds
    assert gaps is not None
    rows = []
    for condition, n_cycles, cell in cells_of(gaps):
        rows_of = records(cell)
        best = rows_of[0]
        anchor = next(row for row in rows_of if row["policy"] == report_data.anchor)
        rows.append(
            [
                format_label(condition), str(n_cycles), significant(best["cost_bound"], 6),
                "the optimum" if best["exact"] else "a lower bound", format_label(best["policy"]), percent(best["gap"]),
                headroom(anchor),
            ]
        )  # fmt: skip
    caption = (
        "The least expected cost that any policy can have, proved by a relaxation without a solver, and how far the "
        f"policies are from it. The last column is the headroom: no policy can save more of the cost of "
        f"`{report_data.anchor}`, so a claim of a larger gain cannot be true here. ± is the standard error of its mean."
    )
    header = [
        "condition", "cycles", "least expected cost", "which is", "best policy", "its mean above the least",
        f"headroom above {format_label(report_data.anchor)}",
    ]  # fmt: skip
    return [Table(caption, header, rows, BOUNDS_FILE)]


def headroom(row: Mapping[str, Any]) -> str:
    """The most that any policy can save of the cost of the policy of a row of `gap_table`, ± its standard error."""
    fraction, error = row["gap"] / (1 + row["gap"]), row["standard_error"] / (1 + row["gap"]) ** 2
    spread = f" ± {percent(error)}" if error > 0 else ""
    return f"{percent(fraction)}{spread}"


@house_style()
def regret_figure(regrets: pd.DataFrame, n_cycles: int, policies: Sequence[str]) -> Figure:
    """Loss per run as share of its cost, one panel per condition, for one number of cycles.

    `regrets` is the table of `statistics.regret`.
    """
    table = regrets[regrets["n_cycles"] == n_cycles]
    conditions = list(dict.fromkeys(table["condition"]))
    figure = new_figure(7.2, 0.8 + 0.2 * len(policies))
    axes = figure.subplots(1, len(conditions), squeeze=False, sharey=True, sharex=True)[0]
    for panel, condition in zip(axes, conditions, strict=True):
        cell = table[table["condition"] == condition].set_index("policy")
        marks = {}
        for index, policy in enumerate(policies):
            if policy not in cell.index:
                continue
            row = cell.loc[policy]
            loss, scale = 100 * row["run_loss_share"], row["run_loss_share"] / row["run_loss"] if row["run_loss"] else 0
            spread = 100 * row["run_loss_standard_error"] * scale
            marks[policy] = loss, WIDE * spread if spread > 0 else None
            panel.annotate(
                f"{loss:.2g}" if loss else "0", (loss + WIDE * max(spread, 0), index), (5, 0),
                textcoords="offset points", va="center", fontsize=7,
            )  # fmt: skip
        mark_policies(panel, policies, policies, marks)
        set_title(panel, f"{format_label(condition)}, {n_cycles} cycles")
        panel.margins(x=0.2)
    axes[0].set_xlim(left=0)
    figure.supxlabel(
        f"lost by the decisions of a run, % of its cost (bars: ±{WIDE:g} standard errors of the mean)", fontsize=9
    )
    return figure

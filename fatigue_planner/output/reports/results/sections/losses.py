"""What the decisions lose against the exact reference, and the cost that no policy can beat."""

from collections.abc import Mapping
from typing import Any

from fatigue_planner.core.text import format_label, listing, percent, significant
from fatigue_planner.output.figures.regret import regret_figure
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.html.blocks import Block, Section, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.planners.reference import describe
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE
from fatigue_planner.study.statistics.pairing import cells_of, groups_of, records

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

"""What the decisions lose against the exact reference, and what no policy can do better."""

from collections.abc import Mapping
from typing import Any

from fatigue_planner.output.figures.regret import regret_figure
from fatigue_planner.output.figures.style import words
from fatigue_planner.output.reports.html.blocks import Block, Section, Table, Text, listing, percent, significant
from fatigue_planner.output.reports.results.figure_folder import Gallery
from fatigue_planner.output.reports.results.report_data import Material
from fatigue_planner.planners.reference import describe
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE
from fatigue_planner.study.statistics.pairing import cells_of, groups_of, records

HOW = "Not measured: `fatplan benchmark --regret --bound` adds it."


def losses_section(material: Material, gallery: Gallery) -> Section:
    """Regret and bounds, or the command that makes them."""
    blocks: list[Block] = []
    if material.regret is None and material.gaps is None:
        blocks.append(Text(HOW))
    if material.regret is not None:
        blocks += _regret(material, gallery)
    if material.gaps is not None and len(material.gaps):
        blocks += _bounds(material)
    return Section("Distance to the optimum", blocks)


def _regret(material: Material, gallery: Gallery) -> list[Block]:
    table = material.regret
    assert table is not None
    judges = material.results.note.references
    named = [condition for condition in material.experiment.benchmark.conditions if condition in judges]
    references = [f"{words(condition)}: {describe(judges[condition])}" for condition in named]
    intro = (
        "Every decision of every run is judged by a reference that looks ahead exactly: "
        + "; ".join(references)
        + ". Regret is the reference's value of the best action minus that of the action taken, summed over a run with "
        "the task's discount. The reference, like the policies, plans for a task without end."
    )
    last = table[table["n_cycles"] == material.longest]
    sentences = [
        f"{words(condition)}: "
        + listing([f"{words(row['policy'])} {percent(row['run_loss_share'])}" for row in records(cell)])
        for condition, cell in groups_of(last, "condition")
    ]
    figure = regret_figure(table, material.longest, material.policies)
    caption = "What the decisions of a run lose against the reference, as share of the run's cost."
    return [Text(intro), gallery.add("regret_by_policy", figure, table, caption, "; ".join(sentences) + ".")]


def _bounds(material: Material) -> list[Block]:
    gaps = material.gaps
    assert gaps is not None
    rows = []
    for condition, n_cycles, cell in cells_of(gaps):
        rows_of = records(cell)
        best = rows_of[0]
        anchor = next(row for row in rows_of if row["policy"] == material.anchor)
        rows.append(
            [
                words(condition), str(n_cycles), significant(best["cost_bound"], 6),
                "the optimum" if best["exact"] else "a lower bound", words(best["policy"]), percent(best["gap"]),
                most_to_win(anchor),
            ]
        )  # fmt: skip
    caption = (
        "The least expected cost that any policy can have, proved by a relaxation without a solver, and how far the "
        "policies are from it. The last column is the most that any policy could win: a claim of a larger win over "
        f"`{material.anchor}` cannot be true here. ± is the standard error of that policy's own mean."
    )
    header = [
        "condition", "cycles", "least expected cost", "which is", "best policy", "its mean above it",
        f"most to win over {words(material.anchor)}",
    ]  # fmt: skip
    return [Table(caption, header, rows, BOUNDS_FILE)]


def most_to_win(row: Mapping[str, Any]) -> str:
    """What could at most be won over the policy of a row of `gap_table`, as a share of its cost, ± standard error."""
    share, error = row["gap"] / (1 + row["gap"]), row["standard_error"] / (1 + row["gap"]) ** 2
    spread = f" ± {percent(error)}" if error > 0 else ""
    return f"{percent(share)}{spread}"

"""The returns: the paper's figure, and the same data as estimates with intervals."""

import pandas as pd

from fatigue_planner.core.text import counted, format_label, listing, percent, percent_range, significant
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.output.figures.estimates import estimate_figure, estimate_table
from fatigue_planner.output.figures.returns import returns_figure
from fatigue_planner.output.figures.style import FigureFolder, Picture
from fatigue_planner.output.reports.html.blocks import Block, Section, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.study.benchmark.results import CONTRASTS_FILE
from fatigue_planner.study.statistics.comparison import STARS
from fatigue_planner.study.statistics.contrast import Verdict, contrasts_in
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
        f"{different} differ, {counts[Verdict.EQUIVALENT]} are equivalent and "
        f"{counts[Verdict.UNDETERMINED]} are undetermined; the paper's test, which neither pairs nor corrects, "
        f"finds a difference in {papers} of {len(both)}. All numbers of every comparison (intervals by t and "
        f"bootstrap, permutation test, effect sizes, smallest detectable difference) are in `{file}`."
    )

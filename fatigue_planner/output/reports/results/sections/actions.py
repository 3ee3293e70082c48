"""Which action when."""

import pandas as pd

from fatigue_planner.core.text import format_label, listing, percent
from fatigue_planner.output.figures.policy_raster import RUNS, raster_figure, raster_table
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.html.blocks import Section
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.study.benchmark.tables import ACTIONS, actions_of
from fatigue_planner.study.statistics.pairing import groups_of


def actions_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """The actions of the longest runs, drawn as a raster."""
    names = list(report_data.experiment.actions)
    table = _counted_in_experiment(raster_table(report_data.results.actions, report_data.longest), report_data)
    caption = (
        f"The action of every cycle in up to {RUNS} runs of {report_data.longest} cycles. A row is a run; the same "
        "row of a condition is the same worker with the same random numbers. A policy with one row is the same in "
        "every run."
    )
    figure = raster_figure(table, names, report_data.policies)
    picture = figures.add("actions_taken", figure, table, caption, _shares(table, names))
    return Section("Which action when", [picture])


def _counted_in_experiment(table: pd.DataFrame, report_data: ReportData) -> pd.DataFrame:
    """The table with the actions' numbers in the experiment; a worker may be able to perform only some of them."""
    order = list(report_data.experiment.actions)
    numbers = {
        cell.condition: [order.index(action) for action in cell.scenario.model.actions] for cell in report_data.cells
    }
    texts = [
        " ".join(str(numbers[condition][action]) for action in actions_of(text))
        for condition, text in zip(table["condition"], table[ACTIONS], strict=True)
    ]
    return table.assign(**{ACTIONS: texts})


def _shares(table: pd.DataFrame, names: list[str]) -> str:
    """The most frequent action of every policy and condition."""
    sentences = []
    for condition, cell in groups_of(table, "condition"):
        favourites = []
        for policy, rows in groups_of(cell, "policy"):
            taken = pd.Series([action for text in rows[ACTIONS] for action in actions_of(text)])
            counts = taken.value_counts(normalize=True)
            favourite = format_label(names[int(counts.index[0])])
            favourites.append(f"{favourite} in {percent(counts.iloc[0], 0)} for {format_label(policy)}")
        sentences.append(f"{format_label(condition)}: {listing(favourites)}")
    return "the most frequent action and how often it is taken; " + "; ".join(sentences) + "."

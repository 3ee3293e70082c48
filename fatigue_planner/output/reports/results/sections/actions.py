"""Which action when."""

import pandas as pd

from fatigue_planner.output.figures.policy_raster import RUNS, raster_figure, raster_table
from fatigue_planner.output.figures.style import words
from fatigue_planner.output.reports.html.blocks import Section, listing, percent
from fatigue_planner.output.reports.results.figure_folder import FigureFolder
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.study.benchmark.tables import ACTIONS, actions_of
from fatigue_planner.study.statistics.pairing import groups_of


def actions_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """The actions of the longest runs, drawn as a raster."""
    names = list(report_data.experiment.actions)
    table = _counted_in_experiment(raster_table(report_data.results.actions, report_data.longest), report_data)
    caption = (
        f"The action of every cycle in up to {RUNS} runs of {report_data.longest} cycles: a row is a run; runs in the "
        "same place of a condition meet the same worker. A policy with one row is the same in every run."
    )
    figure = raster_figure(table, names, report_data.policies)
    picture = figures.add("actions_taken", figure, table, caption, _shares(table, names))
    return Section("Which action when", [picture])


def _counted_in_experiment(table: pd.DataFrame, report_data: ReportData) -> pd.DataFrame:
    """The table with the actions' numbers in the experiment; a worker may be able to perform only some of them."""
    order = list(report_data.experiment.actions)
    numbers = {
        cell.condition: [order.index(action) for action in cell.scenario.model.actions] for cell in report_data.grid
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
            favourites.append(f"{words(policy)} {words(names[int(counts.index[0])])} {percent(counts.iloc[0], 0)}")
        sentences.append(f"{words(condition)}: {listing(favourites)}")
    return "the most frequent action and its share; " + "; ".join(sentences) + "."

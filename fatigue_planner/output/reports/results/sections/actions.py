"""Which action each policy takes when: runs below each other, cycles side by side."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fatigue_planner.core.text import format_label, listing, percent
from fatigue_planner.output.figures.style import FigureFolder, house_style, new_figure, set_title
from fatigue_planner.output.reports.page import Section
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.study.benchmark.tables import ACTIONS, actions_of
from fatigue_planner.study.statistics.pairing import groups_of

RUNS = 20  # shown of each cell
MANY = 8  # actions that are named in the legend; more get a scale


def actions_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """The actions of the longest runs, drawn as a raster."""
    names = list(report_data.experiment.actions)
    taken = report_data.results.actions
    shown = taken[(taken["n_cycles"] == report_data.longest) & (taken["trial"] < RUNS)]
    table = _counted_in_experiment(shown, report_data)
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


@house_style()
def raster_figure(table: pd.DataFrame, action_names: Sequence[str], policies: Sequence[str]) -> Figure:
    """One column of panels per condition, one row per policy; the darker, the later the action in the experiment."""
    conditions = list(dict.fromkeys(table["condition"]))
    shown = [policy for policy in policies if policy in set(table["policy"])]
    figure = new_figure(7.2, 0.5 * len(shown) + 1.1)
    axes = figure.subplots(len(shown), len(conditions), squeeze=False, sharex=True)
    shades = mpl.colormaps["cividis_r"](np.linspace(0.05, 0.95, max(len(action_names), 2)))
    colours, norm = ListedColormap(shades), BoundaryNorm(np.arange(len(shades) + 1) - 0.5, len(shades))
    for column, condition in enumerate(conditions):
        for row, policy in enumerate(shown):
            panel = axes[row, column]
            cell = table[(table["condition"] == condition) & (table["policy"] == policy)]
            image = np.array([actions_of(text) for text in cell[ACTIONS]])
            extent = (0.5, image.shape[1] + 0.5, len(image), 0)
            panel.imshow(image, cmap=colours, norm=norm, aspect="auto", interpolation="nearest", extent=extent)
            panel.set_yticks([])
            if row == 0:
                set_title(panel, format_label(condition))
            if column == 0:
                panel.set_ylabel(format_label(policy), rotation=0, ha="right", va="center")
    figure.supxlabel("cycle", fontsize=9)
    if len(action_names) <= MANY:
        patches = [
            Patch(facecolor=shade, edgecolor="0.4", label=format_label(name))
            for shade, name in zip(shades, action_names, strict=False)
        ]
        figure.legend(handles=patches, loc="outside upper center", ncols=len(patches), frameon=False, fontsize=8)
    else:
        scale = mpl.cm.ScalarMappable(norm, colours)
        figure.colorbar(scale, ax=axes, shrink=0.6, label="number of the action, from 0")
    return figure

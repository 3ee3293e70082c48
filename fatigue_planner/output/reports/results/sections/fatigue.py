"""Fatigue over the cycles, by group of joints and policy."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fatigue_planner.core.text import format_label, listing, percent
from fatigue_planner.fatigue.entries import highest_fatigue
from fatigue_planner.output.figures.style import LINES, FigureFolder, house_style, look, new_figure, set_title
from fatigue_planner.output.reports.page import Section
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.results.sections.law_limits import law_limits

Array = NDArray[np.float64]

SHOWN = 4  # groups of joints: those most tired at the end
SMOOTHED_CYCLES = 10  # fatigue goes up and down with every action; the trend is what tells policies apart


def fatigue_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """How tired each group of joints gets under each policy in the longest runs, and the limits of the law."""
    longest = report_data.longest
    fatigue = {
        (condition, policy): np.array([course.fatigue for course in runs])
        for (condition, n_cycles, policy), runs in report_data.courses.items()
        if n_cycles == longest
    }
    table = fatigue_table(fatigue)
    caption = (
        "Fatigue (0: rested, 1: exhausted) of the most tired degree of freedom of a group of joints: the mean over "
        f"the runs of {longest} cycles and a moving mean over {SMOOTHED_CYCLES} cycles, for the groups that end up "
        "most tired. The data file has all groups and every single cycle."
    )
    last = table[table["cycle"] == longest]
    sentences = []
    for group in most_tired(table):
        mean = last[last["joint_group"] == group].groupby("policy", sort=False)["highest_fatigue"].mean()
        low, high = percent(mean.min(), 0), percent(mean.max(), 0)
        sentences.append(
            f"{format_label(group)} ends at {high} whatever the policy"
            if low == high
            else f"{format_label(group)} ends between {low} ({format_label(str(mean.idxmin()))}) and {high} "
            f"({format_label(str(mean.idxmax()))})"
        )
    alternative = f"after {longest} cycles, averaged over the conditions, " + listing(sentences) + "."
    return Section(
        "Fatigue over the cycles",
        [
            figures.add("fatigue", fatigue_figure(table, report_data.policies), table, caption, alternative),
            *law_limits(report_data),
        ],
    )


def fatigue_table(fatigue: Mapping[tuple[str, str], Array]) -> pd.DataFrame:
    """The most tired entry of every group after every cycle, mean over runs.

    fatigue: (runs, cycles, 78) by condition and policy.
    """
    frames = []
    for (condition, policy), courses in fatigue.items():
        for group, highest in highest_fatigue(courses).items():
            mean = highest.mean(axis=0)
            frames.append(
                pd.DataFrame(
                    {
                        "condition": condition, "policy": policy, "joint_group": group,
                        "cycle": np.arange(1, mean.size + 1), "highest_fatigue": mean,
                    }
                )
            )  # fmt: skip
    return pd.concat(frames, ignore_index=True)


def most_tired(table: pd.DataFrame) -> list[str]:
    """The groups with the highest fatigue after the last cycle, over all conditions and policies."""
    last = table[table["cycle"] == table["cycle"].max()]
    mean = last.groupby("joint_group", sort=False)["highest_fatigue"].mean()
    return [str(group) for group in mean.sort_values(ascending=False, kind="stable").index[:SHOWN]]


@house_style()
def fatigue_figure(table: pd.DataFrame, policies: Sequence[str]) -> Figure:
    """One row of panels per condition, one column for each of the most tired groups, one line per policy."""
    conditions, groups = list(dict.fromkeys(table["condition"])), most_tired(table)
    figure = new_figure(7.2, 1.75 * len(conditions) + 0.9)
    axes = figure.subplots(len(conditions), len(groups), squeeze=False, sharex=True, sharey="col")
    by_line = dict(list(table.groupby(["condition", "joint_group", "policy"], sort=False)))
    for row, condition in enumerate(conditions):
        for column, group in enumerate(groups):
            panel = axes[row, column]
            for index, policy in enumerate(policies):
                line = by_line.get((condition, group, policy))
                if line is None:
                    continue
                marker, colour = look(index)
                every = max(len(line) // 5, 1)
                trend = line["highest_fatigue"].rolling(SMOOTHED_CYCLES, min_periods=1).mean()
                panel.plot(
                    line["cycle"], trend, color=colour, marker=marker, markersize=3.5,
                    markevery=(index * every // len(policies), every), linewidth=1, linestyle=LINES[index % len(LINES)],
                    label=format_label(policy),
                )  # fmt: skip
            if row == 0:
                set_title(panel, format_label(group))
            if column == 0:
                panel.set_ylabel(format_label(condition))
    for panel in axes[-1]:
        panel.set_xlabel("cycle")
    figure.supylabel("fatigue, mean over runs", fontsize=9)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 4), frameon=False, fontsize=8)
    return figure

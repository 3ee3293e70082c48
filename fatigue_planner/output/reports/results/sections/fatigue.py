"""Fatigue over the cycles."""

import numpy as np

from fatigue_planner.core.text import format_label, listing, percent
from fatigue_planner.output.figures.fatigue_course import SMOOTHED_CYCLES, fatigue_figure, fatigue_table, most_tired
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.html.blocks import Section
from fatigue_planner.output.reports.results.report_data import ReportData


def fatigue_section(report_data: ReportData, figures: FigureFolder) -> Section:
    """How tired each group of joints gets under each policy in the longest runs."""
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
        [figures.add("fatigue", fatigue_figure(table, report_data.policies), table, caption, alternative)],
    )

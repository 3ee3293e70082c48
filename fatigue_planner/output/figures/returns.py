"""The paper's Figure 5: discounted accumulated reward per policy, condition and number of cycles."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.style import house_style, look, new_figure, set_title


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
        axes.errorbar(
            index,
            row["mean"],
            yerr=row["standard_deviation"] or None,
            fmt=marker,
            color=colour,
            capsize=3,
            markersize=5,
        )
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

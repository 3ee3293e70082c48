"""Bars of how much of the gain's variance each factor explains alone."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.style import COLOURS, new_figure

HATCHES = ("", "///", "...", "xx")


def importance_figure(table: pd.DataFrame, baselines: Sequence[str]) -> Figure:
    """Bars with bootstrap intervals, the factors in the order of the first baseline, one colour and hatch per baseline.

    `table`: `importance_table`'s rows of one planner, condition and length.
    """
    factors = list(table.loc[table["baseline"] == baselines[0], "factor"])
    height = 0.8 / len(baselines)
    figure = new_figure(7.0, 0.9 + 0.12 * (1 + len(baselines)) * len(factors))
    axes = figure.subplots()
    for number, baseline in enumerate(baselines):
        own = 100 * table[table["baseline"] == baseline].set_index("factor")[["share", "share_low", "share_high"]]
        own = own.loc[factors]
        places = np.arange(len(factors)) + (number - (len(baselines) - 1) / 2) * height
        axes.barh(
            places, own["share"], height, color=COLOURS[number % len(COLOURS)], edgecolor="white",
            hatch=HATCHES[number % len(HATCHES)], label=f"over {format_label(baseline)}",
        )  # fmt: skip
        axes.hlines(places, own["share_low"], own["share_high"], color="black", linewidth=0.8)
    axes.axvline(0, color="0.3", linewidth=0.8)
    axes.set_yticks(range(len(factors)), [format_label(factor) for factor in factors])
    axes.invert_yaxis()
    axes.set_xlabel("variance of the gain that the setting alone explains, % (95 % bootstrap interval)")
    axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(baselines))
    return figure

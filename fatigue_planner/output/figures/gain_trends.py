"""The gain at every combination against the factors that matter most."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.style import COLOURS, new_figure
from fatigue_planner.study.sensitivity.design import Point
from fatigue_planner.study.sensitivity.factors import ChoiceSettings, FactorSettings, SpanSettings, level_text

# Verdict: marker and colour; told apart without colour, too.
LOOKS = {"better": ("o", COLOURS[0]), "undecided": (".", "0.5"), "worse": ("X", COLOURS[1])}


def trend_table(points: Sequence[Point], gains: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """The gains at the combinations, a column more for the level of each factor.

    `gains`: `gain_table`'s rows of one planner, condition and length.
    """
    levels = {point.name: point.levels for point in points if point.design == "space filling"}
    table = gains[gains["point"].isin(levels)].reset_index(drop=True)
    return table.assign(**{name: [levels[point][name] for point in table["point"]] for name in factors})


def trend_figure(table: pd.DataFrame, factors: Mapping[str, FactorSettings], baselines: Sequence[str]) -> Figure:
    """A row of panels per baseline, a column per factor, in each the combinations of `trend_table` with intervals."""
    figure = new_figure(7.0, 2.2 * len(baselines) + 0.3)
    axes = figure.subplots(len(baselines), len(factors), squeeze=False, sharey="row")
    for row, baseline in enumerate(baselines):
        own = table[table["baseline"] == baseline]
        for column, (name, factor) in enumerate(factors.items()):
            _panel(axes[row, column], own, name, factor)
            if row == len(baselines) - 1:
                axes[row, column].set_xlabel(format_label(name))
        axes[row, 0].set_ylabel(f"gain over {format_label(baseline)}, %")
    axes[0, -1].legend(frameon=False, fontsize=7)
    return figure


def _panel(axes: Axes, table: pd.DataFrame, name: str, factor: FactorSettings) -> None:
    if isinstance(factor, ChoiceSettings):
        names = list(factor.levels)
        # spread over the width of a level in the order of the points
        spread = np.linspace(-0.25, 0.25, len(table)) if len(table) > 1 else np.zeros(len(table))
        across = np.array([names.index(str(level)) for level in table[name]]) + spread
        axes.set_xticks(
            range(len(names)), [format_label(level) for level in names], rotation=30, ha="right", fontsize=7
        )
    else:
        across = table[name].to_numpy(dtype=float)
        if isinstance(factor, SpanSettings) and factor.scale == "log":
            axes.set_xscale("log")
            ticks = [factor.level_at(share) for share in (0.0, 0.5, 1.0)]
            axes.set_xticks(np.array(ticks, dtype=float), [level_text(level) for level in ticks])
            axes.minorticks_off()
    gains, low, high = (100 * table[key].to_numpy(dtype=float) for key in ("gain", "gain_low", "gain_high"))
    axes.vlines(across, low, high, color="0.8", linewidth=0.7)
    for verdict, (marker, colour) in LOOKS.items():
        chosen = (table["verdict"] == verdict).to_numpy()
        axes.plot(across[chosen], gains[chosen], marker, color=colour, markersize=4, linestyle="none", label=verdict)
    axes.axhline(0, color="0.3", linewidth=0.8, linestyle=":")

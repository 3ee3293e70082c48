"""Which action each policy takes when: runs below each other, cycles side by side."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.style import house_style, new_figure, set_title
from fatigue_planner.study.benchmark.tables import ACTIONS, actions_of

RUNS = 20  # shown of each cell
MANY = 8  # actions that are named in the legend; more get a scale


def raster_table(actions: pd.DataFrame, n_cycles: int) -> pd.DataFrame:
    """The rows of the table of actions that the figure shows."""
    return actions[(actions["n_cycles"] == n_cycles) & (actions["trial"] < RUNS)]


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

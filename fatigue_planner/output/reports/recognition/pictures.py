"""The figures of a recogniser's page: confusion matrices, the share recognised over the cycle, and reliability."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.motion.settings import PHASES, Cycle
from fatigue_planner.output.figures.style import COLOURS, LINES, MARKERS, house_style, new_figure, set_title
from fatigue_planner.recordings.recognition.confusion import Confusion
from fatigue_planner.recordings.recognition.tables import KNOWN_FROM

MOST_COLUMNS = 3
DARK = 0.5  # from which probability on a cell's number is white


@house_style()
def confusion_figure(confusions: Mapping[str, Confusion]) -> Figure:
    """A panel for every action: what was shown to the left, what it was recognised as below."""
    columns = min(MOST_COLUMNS, len(confusions))
    rows = -(-len(confusions) // columns)
    most = max(len(one.preferences) for one in confusions.values())
    figure = new_figure(7.2, rows * (1.1 + 0.38 * most))
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel, (action, confusion) in zip(panels, confusions.items(), strict=False):
        probability = confusion.probability()
        panel.imshow(probability, cmap="Blues", vmin=0, vmax=1, aspect="auto")
        for (row, column), value in np.ndenumerate(probability):
            colour = "white" if value > DARK else "black"
            panel.text(column, row, f"{value:.2f}", ha="center", va="center", color=colour, fontsize=8)
        panel.set_yticks(range(len(confusion.preferences)), [format_label(one) for one in confusion.preferences])
        names = [format_label(one).replace(" or ", "\nor ") for one in confusion.recognised]
        panel.set_xticks(range(len(names)), names)
        panel.tick_params(length=0)
        set_title(panel, format_label(action))
    for panel in panels[len(confusions) :]:
        panel.set_visible(False)
    figure.supxlabel("recognised as", fontsize=9)
    figure.supylabel("shown", fontsize=9)
    return figure


@house_style()
def early_figure(table: pd.DataFrame, cycle: Cycle) -> Figure:
    """The share that is recognised over the time since the cycle began, a line for every action."""
    figure = new_figure(7.2, 3.4)
    axes = figure.subplots()
    began_s = 0.0
    for number, (phase, lasts_s) in enumerate(zip(PHASES, (cycle.reach_s, cycle.work_s, cycle.return_s), strict=True)):
        if number % 2 == 0:
            axes.axvspan(began_s, began_s + lasts_s, color="0.94", linewidth=0, zorder=0)
        axes.text(began_s + lasts_s / 2, 1.02, phase, ha="center", va="bottom", transform=axes.get_xaxis_transform())
        began_s += lasts_s
    for number, (action, own) in enumerate(table.groupby("action", sort=False)):
        axes.plot(
            own["time_s"], own["recognised"], color=COLOURS[number % len(COLOURS)], markersize=3.5,
            marker=MARKERS[number % len(MARKERS)], linestyle=LINES[number // len(COLOURS) % len(LINES)],
            label=format_label(str(action)),
        )  # fmt: skip
    axes.axhline(KNOWN_FROM, color="0.3", linewidth=0.8, linestyle="--")
    axes.set_xlim(0, began_s)
    axes.set_ylim(min(0.4, float(table["recognised"].min()) - 0.05), 1.01)
    axes.set_xlabel("time since the cycle began, s")
    axes.set_ylabel("share recognised")
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure


@house_style()
def reliability_figure(table: pd.DataFrame) -> Figure:
    """How often it is right over how probable it held it, a panel for every moment."""
    figure = new_figure(7.2, 2.7)
    moments = list(dict.fromkeys(table["after"]))
    panels = figure.subplots(1, len(moments), sharey=True, squeeze=False)[0]
    for panel, moment in zip(panels, moments, strict=True):
        own = table[table["after"] == moment]
        panel.plot([0, 1], [0, 1], color="0.5", linewidth=0.8)
        sizes = 6 + 90 * own["repetitions"] / own["repetitions"].sum()
        panel.scatter(own["probability"], own["right"], s=sizes, color=COLOURS[0], alpha=0.8, linewidth=0)
        least = min(0.3, float(table[["probability", "right"]].min().min()) - 0.05)
        panel.set_xlim(least, 1.02)
        panel.set_ylim(least, 1.02)
        panel.set_aspect("equal")
        set_title(panel, f"after {moment}")
    panels[0].set_ylabel("share right")
    figure.supxlabel("probability of what is recognised", fontsize=9)
    return figure

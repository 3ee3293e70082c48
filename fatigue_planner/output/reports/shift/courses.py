"""A worker's fatigue over the shift: what was believed, how surely, and the pauses."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label, listing, percent, percent_range
from fatigue_planner.live.doses import HOUR_S
from fatigue_planner.output.figures.style import COLOURS, FigureFolder, Picture, house_style, new_figure, set_title
from fatigue_planner.output.reports.shift.data import ShiftData, offset
from fatigue_planner.study.statistics.pairing import records

SHOWN = 4  # entries: those whose fatigue was highest
MAX_GAP_S = 180.0  # over longer times of which nothing is known, no line is drawn


def most_tired(table: pd.DataFrame, count: int) -> pd.DataFrame:
    """The rows of `ShiftData.fatigue_table` in which the most tired entries were so, the most tired one first."""
    highest = table.loc[table.groupby("entry", sort=False)["mean"].idxmax()]
    return highest[highest["mean"] > 0].sort_values("mean", ascending=False, kind="stable").head(count)


def course_picture(data: ShiftData, worker: str, table: pd.DataFrame, figures: FigureFolder) -> Picture:
    """The courses of the most tired entries, with their words and data."""
    highest = most_tired(table, SHOWN)
    words = [
        f"{format_label(row['entry'])} reached {percent(row['mean'], 0)} at {row['time'][11:16]} "
        f"(90 % interval {percent_range(row['low'], row['high'], 0)})"
        for row in records(highest)
    ]
    caption = (
        "Estimated fatigue (0: rested, 1: exhausted) of the muscles that were most tired, after every cycle and pause. "
        "The line is the mean of what was believed, the band holds 90 % of it; grey are pauses. No line: nothing was "
        "estimated."
    )
    figure = course_figure(data, worker, table, [str(entry) for entry in highest["entry"]])
    return figures.add("fatigue", figure, table, caption, listing(words) + ".")


@house_style()
def course_figure(data: ShiftData, worker: str, table: pd.DataFrame, entries: Sequence[str]) -> Figure:
    """A panel below the other for each entry; time of day below."""
    figure = new_figure(7.2, 1.35 * len(entries) + 0.5)
    panels = figure.subplots(len(entries), 1, squeeze=False, sharex=True, sharey=True)[:, 0]
    for number, (panel, entry) in enumerate(zip(panels, entries, strict=True)):
        own = table[table["entry"] == entry]
        at_s = own["at_s"].to_numpy()
        breaks = np.flatnonzero(np.diff(at_s) > MAX_GAP_S) + 1
        hours, mean, low, high = (
            np.insert(own[name].to_numpy(float), breaks, np.nan) for name in ("at_s", "mean", "low", "high")
        )
        hours = (hours - data.first_hour_s) / HOUR_S
        colour = COLOURS[number % len(COLOURS)]
        panel.fill_between(hours, low, high, color=colour, alpha=0.25, linewidth=0)
        panel.plot(hours, mean, color=colour, linewidth=0.9)
        for pause in data.pauses:
            if pause.worker == worker:
                end = (pause.ended_s - data.first_hour_s) / HOUR_S
                panel.axvspan(end - pause.seconds / HOUR_S, end, color="0.88", linewidth=0, zorder=0)
        set_title(panel, format_label(entry))
    shown = table[table["entry"].isin(entries)]
    panels[-1].set_ylim(0, min(1.0, np.ceil(8 * float(shown["high"].max()) + 0.1) / 8))
    began, ended = ((float(value) - data.first_hour_s) / HOUR_S for value in (table["at_s"].min(), table["at_s"].max()))
    panels[-1].set_xlim(began, max(ended, began + 0.1))
    every = max(0.25, 2.0 ** np.ceil(np.log2(max(ended - began, 0.1) / 8)))  # a quarter of an hour or more
    ticks = np.arange(np.ceil(began / every), max(ended, began + 0.1) / every) * every
    panels[-1].set_xticks(ticks, [f"{data.record.local(data.first_hour_s + hour * HOUR_S):%H:%M}" for hour in ticks])
    panels[-1].set_xlabel(f"time of day ({offset(data.record.local(0))})")
    figure.supylabel("fatigue", fontsize=9)
    return figure

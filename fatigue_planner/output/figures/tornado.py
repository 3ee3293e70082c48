"""A tornado chart: how far each factor alone moves the gain."""

from collections.abc import Sequence

import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.style import COLOURS, new_figure
from fatigue_planner.study.sensitivity.design import Point
from fatigue_planner.study.sensitivity.factors import level_text

COLUMNS = ["factor", "level", "gain", "gain_low", "gain_high"]


def tornado_table(points: Sequence[Point], gains: pd.DataFrame) -> pd.DataFrame:
    """The gain at every level tried one at a time (COLUMNS), the widest swing first; the base experiment's comes first.

    `gains`: `gain_table`'s rows of one planner, baseline, condition and length.
    """
    by_point = gains.set_index("point")
    rows = [
        (
            point.factor,
            level_text(point.levels[point.factor]) if point.factor else "",
            *by_point.loc[point.name, COLUMNS[2:]],
        )
        for point in points
        if point.design != "space filling" and point.name in by_point.index
    ]
    table = pd.DataFrame(rows, columns=COLUMNS)
    if table.empty:
        return table
    base = table.loc[table["factor"] == "", "gain"]
    groups = table.groupby("factor")["gain"]
    most, least = groups.max(), groups.min()
    if len(base):
        most, least = most.clip(lower=base.iloc[0]), least.clip(upper=base.iloc[0])
    swing = (most - least).to_dict() | {"": float("inf")}
    return table.sort_values("factor", key=lambda names: -names.map(swing), kind="stable").reset_index(drop=True)


def tornado_figure(table: pd.DataFrame, title: str) -> Figure:
    """One bar per factor from the least to the largest gain of `tornado_table`, a mark at every level."""
    factors = [name for name in dict.fromkeys(table["factor"]) if name]
    base = table.loc[table["factor"] == "", "gain"]
    figure = new_figure(7.0, 0.9 + 0.3 * len(factors))
    axes = figure.subplots()
    for place, factor in enumerate(factors):
        own = table[table["factor"] == factor]
        gains = 100 * pd.concat([own["gain"], base])
        axes.barh(place, gains.max() - gains.min(), left=gains.min(), height=0.55, color=COLOURS[5], edgecolor="0.3")
        axes.plot(100 * own["gain"], [place] * len(own), marker="|", color="black", linestyle="none", markersize=9)
        if gains.max() == gains.min():
            axes.annotate(
                "no effect", (gains.min(), place), (4, 0), textcoords="offset points", va="center", fontsize=7
            )
            continue
        ends = own.sort_values("gain", kind="stable")
        sides = [(ends.iloc[0], "right", -4), (ends.iloc[-1], "left", 4)]
        if len(base):  # an end that is the base experiment's own has its line
            sides = [(row, side, shift) for row, side, shift in sides if (row["gain"] - base.iloc[0]) * shift > 0]
        for row, side, shift in sides:
            axes.annotate(
                format_label(row["level"]), (100 * row["gain"], place), (shift, 0), textcoords="offset points", ha=side,
                va="center", fontsize=7,
            )  # fmt: skip
    for value in base:
        axes.axvline(100 * value, color="black", linewidth=0.8)
    axes.axvline(0, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_yticks(range(len(factors)), [format_label(factor) for factor in factors])
    axes.invert_yaxis()
    axes.use_sticky_edges = False
    axes.margins(x=0.18)
    axes.set_xlabel("gain, % of the baseline's cost (line: the base experiment)")
    axes.set_title(title)
    return figure

"""The figures of a sensitivity study: what each factor does alone, what decides, and the gain at every combination."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fatigue_planner.core.files import writable_folder
from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.style import COLOURS, FigureFolder, house_style, new_figure, set_title
from fatigue_planner.study.sensitivity.conclusions import MAX_NAMED, of_headline
from fatigue_planner.study.sensitivity.design import Point
from fatigue_planner.study.sensitivity.factors import FactorSettings, NamedLevels, SpanSettings, level_text
from fatigue_planner.study.sensitivity.study import Study
from fatigue_planner.study.sensitivity.tables import StudyTables

HATCHES = ("", "///", "...", "xx")
# Verdict: marker and colour; told apart without colour, too.
VERDICT_LOOKS = {"better": ("o", COLOURS[0]), "undecided": (".", "0.5"), "worse": ("X", COLOURS[1])}
TORNADO_COLUMNS = ["factor", "level", "gain", "gain_low", "gain_high"]


def draw_study(study: Study, points: Sequence[Point], tables: StudyTables, folder: Path) -> list[Path]:
    """A tornado chart per baseline; where combinations can be performed, importance and trends; the headline's.

    Nothing without combinations: a few points are for tables.
    """
    if tables.importance is None:
        return []
    headline, baselines = study.settings.headline, study.settings.baselines
    gains, importance = of_headline(tables.gains, headline), of_headline(tables.importance, headline)
    figures = FigureFolder(writable_folder(folder))
    for baseline in baselines:
        table = tornado_table(points, gains[gains["baseline"] == baseline])
        where = f"{format_label(headline.condition)}, {headline.n_cycles} cycles"
        title = f"{format_label(headline.planner)} over {format_label(baseline)}, {where}"
        figures.add(f"tornado_{baseline}", tornado_figure(table, title), table)
    if importance["share"].notna().any():
        figures.add("importance", importance_figure(importance, baselines), importance)
        deciding = importance.loc[importance["baseline"] == baselines[0], "factor"].iloc[:MAX_NAMED]
        factors = {name: study.settings.factors[name] for name in deciding}
        trends = trend_table(points, gains, list(factors))
        figures.add("trends", trend_figure(trends, factors, baselines), trends)
    return figures.files


def tornado_table(points: Sequence[Point], gains: pd.DataFrame) -> pd.DataFrame:
    """The gain at every level tried one at a time (TORNADO_COLUMNS), the base experiment's before the widest swing.

    `gains`: `gain_table`'s rows of one planner, baseline, condition and length.
    """
    by_point = gains.set_index("point")
    rows = [
        (
            point.factor,
            level_text(point.levels[point.factor]) if point.factor else "",
            *by_point.loc[point.name, TORNADO_COLUMNS[2:]],
        )
        for point in points
        if point.design != "space filling" and point.name in by_point.index
    ]
    table = pd.DataFrame(rows, columns=TORNADO_COLUMNS)
    if table.empty:
        return table
    base = table.loc[table["factor"] == "", "gain"]
    groups = table.groupby("factor")["gain"]
    most, least = groups.max(), groups.min()
    if len(base):
        most, least = most.clip(lower=base.iloc[0]), least.clip(upper=base.iloc[0])
    swing = (most - least).to_dict() | {"": float("inf")}
    return table.sort_values("factor", key=lambda names: -names.map(swing), kind="stable").reset_index(drop=True)


@house_style()
def tornado_figure(table: pd.DataFrame, title: str) -> Figure:
    """One bar per factor from the least to the largest gain of `tornado_table`, a mark at every level."""
    factors = [name for name in dict.fromkeys(table["factor"]) if name]
    base = table.loc[table["factor"] == "", "gain"]
    figure = new_figure(7.0, 0.9 + 0.3 * len(factors))
    axes = figure.subplots()
    for index, factor in enumerate(factors):
        own = table[table["factor"] == factor]
        gains = 100 * pd.concat([own["gain"], base])
        axes.barh(index, gains.max() - gains.min(), left=gains.min(), height=0.55, color=COLOURS[5], edgecolor="0.3")
        axes.plot(100 * own["gain"], [index] * len(own), marker="|", color="black", linestyle="none", markersize=9)
        if gains.max() == gains.min():
            axes.annotate(
                "no effect", (gains.min(), index), (4, 0), textcoords="offset points", va="center", fontsize=7
            )
            continue
        ends = own.sort_values("gain", kind="stable")
        sides = [(ends.iloc[0], "right", -4), (ends.iloc[-1], "left", 4)]
        if len(base):  # an end that is the base experiment's own has its line
            sides = [(row, side, shift) for row, side, shift in sides if (row["gain"] - base.iloc[0]) * shift > 0]
        for row, side, shift in sides:
            axes.annotate(
                format_label(row["level"]), (100 * row["gain"], index), (shift, 0), textcoords="offset points", ha=side,
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
    set_title(axes, title)
    return figure


@house_style()
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
        heights = np.arange(len(factors)) + (number - (len(baselines) - 1) / 2) * height
        axes.barh(
            heights, own["share"], height, color=COLOURS[number % len(COLOURS)], edgecolor="white",
            hatch=HATCHES[number % len(HATCHES)], label=f"over {format_label(baseline)}",
        )  # fmt: skip
        axes.hlines(heights, own["share_low"], own["share_high"], color="black", linewidth=0.8)
    axes.axvline(0, color="0.3", linewidth=0.8)
    axes.set_yticks(range(len(factors)), [format_label(factor) for factor in factors])
    axes.invert_yaxis()
    axes.set_xlabel("variance of the gain that the setting alone explains, % (95 % bootstrap interval)")
    axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(baselines))
    return figure


def trend_table(points: Sequence[Point], gains: pd.DataFrame, factors: Sequence[str]) -> pd.DataFrame:
    """The gains at the combinations, a column more for the level of each factor.

    `gains`: `gain_table`'s rows of one planner, condition and length.
    """
    levels = {point.name: point.levels for point in points if point.design == "space filling"}
    table = gains[gains["point"].isin(levels)].reset_index(drop=True)
    return table.assign(**{name: [levels[point][name] for point in table["point"]] for name in factors})


@house_style()
def trend_figure(table: pd.DataFrame, factors: Mapping[str, FactorSettings], baselines: Sequence[str]) -> Figure:
    """A row of panels per baseline, a column per factor, in each the combinations of `trend_table` with intervals."""
    figure = new_figure(7.0, 2.2 * len(baselines) + 0.3)
    axes = figure.subplots(len(baselines), len(factors), squeeze=False, sharey="row")
    for row, baseline in enumerate(baselines):
        own = table[table["baseline"] == baseline]
        for column, (name, factor) in enumerate(factors.items()):
            _trend_panel(axes[row, column], own, name, factor)
            if row == len(baselines) - 1:
                axes[row, column].set_xlabel(format_label(name))
        axes[row, 0].set_ylabel(f"gain over {format_label(baseline)}, %")
    axes[0, -1].legend(frameon=False, fontsize=7)
    return figure


def _trend_panel(axes: Axes, table: pd.DataFrame, name: str, factor: FactorSettings) -> None:
    if isinstance(factor, NamedLevels):
        names = list(map(str, factor.all_levels()))
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
    for verdict, (marker, colour) in VERDICT_LOOKS.items():
        chosen = (table["verdict"] == verdict).to_numpy()
        axes.plot(across[chosen], gains[chosen], marker, color=colour, markersize=4, linestyle="none", label=verdict)
    axes.axhline(0, color="0.3", linewidth=0.8, linestyle=":")

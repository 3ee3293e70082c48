"""Figures over a recording's time: markers, forces that no plate explains, angles and torques."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fatigue_planner.core.text import format_label
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.output.figures.style import COLOURS, LINES, house_style, new_figure, set_title
from fatigue_planner.recordings.imports.imported import Imported

Vector = NDArray[np.float64]

# Room above the lines for the legend.
LEGEND_SHARE = 0.3
# What is drawn of angles and torques, panel by panel; the table beside the figure has all.
ARM = ("shoulder_flexion", "shoulder_abduction", "elbow_flexion", "wrist_flexion")
LEG = ("hip_flexion", "knee_flexion", "ankle_flexion")
PANELS: dict[str, tuple[str, ...]] = {
    "trunk and neck": ("lumbar_flexion", "lumbar_lateral", "thoracic_flexion", "neck_flexion"),
    **{f"{side} arm": tuple(f"{side}_{name}" for name in ARM) for side in SIDES},
    **{f"{side} leg": tuple(f"{side}_{name}" for name in LEG) for side in SIDES},
}


def times_s(made: Imported) -> Vector:
    """The times (n,) of the frames."""
    return np.arange(len(made.track.configuration)) / made.track.rate_hz


@house_style()
def markers_figure(made: Imported) -> tuple[Figure, pd.DataFrame]:
    """How far the markers are from their places: RMS of all, and the farthest, frame by frame."""
    distance = 1000 * np.nan_to_num(made.track.distance_m)
    table = pd.DataFrame(
        {"time_s": times_s(made), "rms_mm": 1000 * made.track.rms_m, "farthest_mm": distance.max(axis=1)}
    )
    return _lines(made, table, {"all markers, RMS": "rms_mm", "the farthest": "farthest_mm"}, "distance, mm"), table


@house_style()
def residuals_figure(made: Imported) -> tuple[Figure, pd.DataFrame]:
    """The force and the moment about the hips that no plate explains."""
    force, moment = made.torques.residual_force_n, made.torques.residual_moment_nm
    table = pd.DataFrame({"time_s": times_s(made)})
    for axis, name in enumerate(("forward", "left", "up")):
        table[f"force_{name}_n"] = force[:, axis]
    for axis, name in enumerate(("sideways", "forward", "turn")):
        table[f"moment_{name}_nm"] = moment[:, axis]
    figure = new_figure(7.2, 4.2)
    upper, lower = figure.subplots(2, 1, sharex=True)
    _draw(upper, made, table, {name: f"force_{name}_n" for name in ("forward", "left", "up")}, "force, N")
    _draw(
        lower, made, table,
        {"bends sideways": "moment_sideways_nm", "bends forward": "moment_forward_nm", "turns": "moment_turn_nm"},
        "moment, N·m",
    )  # fmt: skip
    lower.set_xlabel("time of the recording, s")
    return figure, table


@house_style()
def angles_figure(made: Imported) -> tuple[Figure, pd.DataFrame]:
    """The joint angles of all frames in degrees."""
    return _panels(made, np.degrees(made.movement.configuration[:, 7:]), "deg", "angle, °")


@house_style()
def torques_figure(made: Imported) -> tuple[Figure, pd.DataFrame]:
    """The joint torques of all frames, without those that nobody measured."""
    measured = np.where(made.reaction.assumed, np.nan, made.torques.torque_nm)
    return _panels(made, measured, "nm", "torque, N·m")


def _panels(made: Imported, values: Vector, unit: str, label: str) -> tuple[Figure, pd.DataFrame]:
    columns = dict(zip(DEGREES_OF_FREEDOM, values.T, strict=True))
    table = pd.DataFrame({"time_s": times_s(made)} | {f"{name}_{unit}": column for name, column in columns.items()})
    figure = new_figure(7.2, 7.2)
    grid = figure.subplots(3, 2, sharex=True).ravel()
    for axes, (title, names) in zip(grid, PANELS.items(), strict=False):
        shown = [name for name in names if np.isfinite(columns[name]).any()]
        short = {format_label(_short(name)): f"{name}_{unit}" for name in shown}
        _draw(axes, made, table, short, label)
        set_title(axes, title)
    for axes in grid[len(PANELS) :]:
        axes.set_visible(False)
    for axes in grid[-3:]:
        axes.set_xlabel("time of the recording, s")
        axes.tick_params(labelbottom=True)
    return figure, table


def _short(name: str) -> str:
    return name.removeprefix("right_").removeprefix("left_")


def _lines(made: Imported, table: pd.DataFrame, columns: Mapping[str, str], label: str) -> Figure:
    figure = new_figure(7.2, 2.6)
    axes = figure.subplots()
    _draw(axes, made, table, columns, label)
    axes.set_xlabel("time of the recording, s")
    return figure


def _draw(axes: Axes, made: Imported, table: pd.DataFrame, columns: Mapping[str, str], label: str) -> None:
    """Lines over time, and where each phase begins and ends."""
    for index, (name, column) in enumerate(columns.items()):
        axes.plot(
            table["time_s"], table[column], color=COLOURS[index % len(COLOURS)], linestyle=LINES[index % len(LINES)],
            linewidth=1.0, label=name,
        )  # fmt: skip
    for time in made.bounds:
        axes.axvline(time, color="0.6", linewidth=0.8, linestyle=":")
    axes.set_ylabel(label)
    axes.margins(x=0)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + LEGEND_SHARE * (high - low))
    axes.legend(fontsize=7, loc="upper right", framealpha=0.8, ncols=2)


def largest(table: pd.DataFrame, columns: Sequence[str]) -> str:
    """In words, which of some columns has the largest magnitude, and how much."""
    magnitude = table[list(columns)].abs().max()
    name = str(magnitude.idxmax())
    return f"{format_label(name.rpartition('_')[0])}, {magnitude[name]:.0f}"

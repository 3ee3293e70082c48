"""The postural reactions at mid-work (like the paper's Figure 2) or at chosen times, joints coloured by load."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fatigue_planner.core.text import format_label
from fatigue_planner.fatigue.entries import joint_load_fractions
from fatigue_planner.fatigue.load import load_share
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.model import Human
from fatigue_planner.human.skeleton import JOINTS, SIDES
from fatigue_planner.output.figures.human_drawing import (
    FRONT,
    SIDE,
    View,
    draw_human,
    draw_joint_loads,
    draw_load_scale,
    fit_panels,
    landmarks,
)
from fatigue_planner.output.figures.style import SETTINGS, house_style, new_figure, set_title, wrapped
from fatigue_planner.output.viewer.motion_clip import MotionClip
from fatigue_planner.reactions.reaction import Reaction

Vector = NDArray[np.float64]

# Up to so many reactions are drawn from two sides in one row; more from the right only, in rows of at most WIDEST.
FEW = 9
WIDEST = 15


@house_style()
def posture_figure(
    human: Human, reactions: Sequence[Reaction], parameters: FatigueParameters
) -> tuple[Figure, pd.DataFrame]:
    """A worker's reactions at mid-work, joints coloured by load; landmarks and loads as data."""
    few = len(reactions) <= FEW
    across = len(reactions) if few else _columns(reactions)
    views: tuple[View, ...] = (SIDE, FRONT) if few else (SIDE,)
    rows_of_panels = len(views) * -(-len(reactions) // across)
    figure = new_figure(1.85 * across, 5.2) if few else new_figure(1.0 * across, 1.75 * rows_of_panels + 0.8)
    axes = figure.subplots(rows_of_panels, across, squeeze=False)
    for panel in axes.flat:
        panel.set_axis_off()
    rows = []
    for index, reaction in enumerate(reactions):
        tick = reaction.motion.middle("work")
        points = landmarks(human, reaction.motion.configuration[tick])
        shares = joint_load_fractions(load_share(reaction.motion, parameters)[tick])
        row, column = divmod(index, across)
        for number, view in enumerate(views):
            panel = axes[row * len(views) + number, column]
            draw_human(panel, human, points, view, working_hands(reaction))
            if few and column == 0:
                panel.text(-0.05, 0.5, view.name, transform=panel.transAxes, rotation=90, va="center")
            discs = draw_joint_loads(panel, points, shares, view)
        action, preference = format_label(reaction.name.action), format_label(reaction.name.preference)
        if few:
            set_title(axes[row * len(views), column], f"{action}, {preference} reaction")
        else:
            set_title(axes[row * len(views), column], f"{action}\n{preference}", 5.5)
        share_at = {joint.child: shares[joint.name] for joint in JOINTS}
        for landmark, position in points.items():
            rows.append(
                reaction.name._asdict()
                | {"landmark": landmark}
                | dict(zip(("x_m", "y_m", "z_m"), position, strict=True))
                | {"share_of_maximum": share_at.get(landmark, np.nan)}
            )
    fit_panels([panel for panel in axes.flat if panel.has_data()], human)
    draw_load_scale(figure, axes[-1], discs, 0.7)
    return figure, pd.DataFrame(rows)


def representative_times(clip: MotionClip) -> list[float]:
    """The start of the cycle and the middle of every phase, in s."""
    motion = clip.motion
    return [0.0, *(motion.middle(phase.name) * motion.time_step_s for phase in motion.phases)]


@house_style()
def filmstrip(clips: Sequence[MotionClip], times_s: Sequence[float]) -> Figure:
    """One row per clip, one panel per time, seen from the right, joints coloured by load.

    Without times, those that `representative_times` gives for each clip.
    """
    rows = [list(times_s) or representative_times(clip) for clip in clips]
    columns = max(len(row) for row in rows)
    figure = new_figure(1.6 * columns + 0.3, 2.35 * len(rows) + 0.7)
    axes = figure.subplots(len(rows), columns, squeeze=False)
    for panels, clip, times in zip(axes, clips, rows, strict=True):
        for panel, time in zip(panels, times, strict=False):
            tick = clip.tick(time)
            points = landmarks(clip.human, clip.motion.configuration[tick])
            draw_human(panel, clip.human, points, SIDE, clip.working)
            discs = draw_joint_loads(panel, points, clip.instant(tick).joint_share, SIDE)
            set_title(panel, f"{clip.phase(tick)}, {time:g} s")
        for panel in panels[len(times) :]:
            panel.set_axis_off()
        fit_panels(panels[: len(times)], clip.human)
        title = wrapped(format_label(clip.title), 2.0, SETTINGS["font.size"])
        panels[0].text(-0.06, 0.5, title, transform=panels[0].transAxes, rotation=90, va="center")
    draw_load_scale(figure, axes[-1], discs, 0.8)
    return figure


def working_hands(reaction: Reaction) -> list[str]:
    """The sides whose hands have a goal in the reaction's action."""
    return [side for side in SIDES if reaction.key.settings["action"][f"{side}_hand"] is not None]


def _columns(reactions: Sequence[Reaction]) -> int:
    """Panels in a row: all preferences of as many actions as fit."""
    preferences = len({reaction.name.preference for reaction in reactions})
    return max(WIDEST // preferences, 1) * preferences

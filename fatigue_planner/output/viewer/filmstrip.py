"""The poses at chosen times side by side, for a paper."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.human_drawing import SIDE, draw_human, draw_joint_loads, draw_load_scale, landmarks
from fatigue_planner.output.figures.style import new_figure
from fatigue_planner.output.viewer.motion_clip import MotionClip


def representative_times(clip: MotionClip) -> list[float]:
    """The start of the cycle and the middle of every phase, in s."""
    motion = clip.motion
    return [0.0, *(motion.middle(phase.name) * motion.time_step_s for phase in motion.phases)]


def strip(clips: Sequence[MotionClip], times_s: Sequence[float]) -> Figure:
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
            panel.set_title(f"{clip.phase(tick)}, {time:g} s")
        for panel in panels[len(times) :]:
            panel.set_axis_off()
        panels[0].text(-0.06, 0.5, format_label(clip.title), transform=panels[0].transAxes, rotation=90, va="center")
    draw_load_scale(figure, axes[-1], discs, 0.8)
    return figure

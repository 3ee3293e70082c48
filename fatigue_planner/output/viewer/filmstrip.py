"""The poses at chosen times side by side, for a paper."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from fatigue_planner.output.figures.human_drawing import SIDE, draw_human, draw_joint_loads, draw_load_scale, landmarks
from fatigue_planner.output.figures.style import new_figure, words
from fatigue_planner.output.viewer.motion_clip import Performance


def telling_times(performance: Performance) -> list[float]:
    """The start of the cycle and the middle of every phase, in s."""
    motion = performance.motion
    return [0.0, *(motion.middle(phase.name) * motion.time_step_s for phase in motion.phases)]


def strip(performances: Sequence[Performance], times_s: Sequence[float]) -> Figure:
    """One row per performance, one panel per time, seen from the right, joints coloured by load.

    Without times, those that `telling_times` gives for each performance.
    """
    rows = [list(times_s) or telling_times(performance) for performance in performances]
    columns = max(len(row) for row in rows)
    figure = new_figure(1.6 * columns + 0.3, 2.35 * len(rows) + 0.7)
    axes = figure.subplots(len(rows), columns, squeeze=False)
    for panels, performance, times in zip(axes, performances, rows, strict=True):
        for panel, time in zip(panels, times, strict=False):
            tick = performance.tick(time)
            points = landmarks(performance.human, performance.motion.configuration[tick])
            draw_human(panel, performance.human, points, SIDE, performance.working)
            discs = draw_joint_loads(panel, points, performance.instant(tick).joint_share, SIDE)
            panel.set_title(f"{performance.phase(tick)}, {time:g} s")
        for panel in panels[len(times) :]:
            panel.set_axis_off()
        panels[0].text(-0.06, 0.5, words(performance.title), transform=panels[0].transAxes, rotation=90, va="center")
    draw_load_scale(figure, axes[-1], discs, 0.8)
    return figure

"""The poses at chosen times side by side, for a paper."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from fatigue_planner.figures.human_drawing import SIDE, draw_human, draw_joint_loads, landmarks
from fatigue_planner.figures.style import new_figure, words
from fatigue_planner.viewer.performance import Performance


def telling_times(performance: Performance) -> list[float]:
    """The start of the cycle and the middle of every phase, in s."""
    step = performance.motion.time_step_s
    return [0.0, *((phase.start + phase.stop) // 2 * step for phase in performance.motion.phases)]


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
    label = "largest load at the joint, % of the maximum torque \n(blue squares: the fists that work)"
    figure.colorbar(discs, ax=list(axes[-1]), location="bottom", shrink=0.8, aspect=50, label=label, extend="max")
    return figure

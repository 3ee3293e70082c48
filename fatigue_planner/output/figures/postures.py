"""The postural reactions at mid-work (like the paper's Figure 2) or at chosen times, joints coloured by load."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import pinocchio as pin
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from fatigue_planner.core.text import format_label
from fatigue_planner.fatigue.entries import joint_load_fractions
from fatigue_planner.fatigue.load import load_share
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.model import Human
from fatigue_planner.human.skeleton import JOINTS, SIDES
from fatigue_planner.output.figures.style import SETTINGS, house_style, new_figure, set_title, wrapped
from fatigue_planner.output.viewer.motion_clip import MotionClip
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.robot.shape import RobotShape

Vector = NDArray[np.float64]

# Up to so many reactions are drawn from two sides in one row; more from the right only, in rows of at most WIDEST.
FEW = 9
WIDEST = 15
# (from, to, radius as a share of stature); the radii are for the eye only.
CAPSULES = (
    ("pelvis", "abdomen", 0.062), ("abdomen", "thorax", 0.066), ("thorax", "shoulders", 0.070),
    ("neck", "head", 0.030), ("right_thigh", "left_thigh", 0.050), ("right_upper_arm", "left_upper_arm", 0.034),
    *((f"{side}_{start}", f"{side}_{end}", radius) for side in SIDES for start, end, radius in (
        ("upper_arm", "forearm", 0.024), ("forearm", "hand", 0.019), ("hand", "grip", 0.018),
        ("thigh", "shank", 0.040), ("shank", "foot", 0.028), ("heel", "toe", 0.020),
    )),
)  # fmt: skip
_BODY, _RIGHT, _TOOL, _ROBOT = "#C9D1D9", "#9AA8B5", "#0072B2", "#3E546A"


@dataclass(frozen=True)
class View:
    """A direction of sight: world axes to the right of the picture and towards the viewer."""

    name: str
    across: Vector
    towards: Vector


SIDE = View("from the right", np.array([1.0, 0, 0]), np.array([0, -1.0, 0]))
FRONT = View("from the front", np.array([0, 1.0, 0]), np.array([1.0, 0, 0]))


def landmarks(human: Human, configuration: Vector) -> dict[str, Vector]:
    """Positions (3,) m of the bodies' frames, fists, soles, shoulders' middle, heels, toes and crown."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, configuration)
    poses = {frame.name: data.oMf[i] for i, frame in enumerate(human.model.frames) if frame.name != "universe"}
    points = {name: pose.translation.copy() for name, pose in poses.items()}
    points["shoulders"] = (points["right_upper_arm"] + points["left_upper_arm"]) / 2
    points["head_centre"] = poses["head"].act(np.array([0, 0, 0.065 * human.anthropometry.stature_m]))
    heel, toe, _, height = human.anthropometry.sole_rectangle()
    for side in SIDES:
        for name, x in (("heel", heel), ("toe", toe)):
            points[f"{side}_{name}"] = poses[f"{side}_foot"].act(np.array([x, 0, height]))
    return points


def draw_human(axes: Axes, human: Human, points: Mapping[str, Vector], view: View, working: Sequence[str]) -> None:
    """Draw the body, squares at the fists that work and the ground, far parts first."""
    stature = human.anthropometry.stature_m

    def flat(point: Vector) -> Vector:
        return np.array([point @ view.across, point[2]])

    def nearness(capsule: tuple[str, str, float]) -> float:
        return float((points[capsule[0]] + points[capsule[1]]) @ view.towards)

    axes.axhline(0, color="0.6", linewidth=0.8, zorder=0)
    head = ("head_centre", "head_centre", 0.060)
    for start, end, radius in sorted([*CAPSULES, head], key=nearness):
        colour = _RIGHT if start.startswith("right") and end.startswith("right") else _BODY
        outline = _capsule(flat(points[start]), flat(points[end]), radius * stature)
        axes.fill(*outline.T, facecolor=colour, edgecolor="white", linewidth=0.8)
    for side in working:
        axes.plot(*flat(points[f"{side}_grip"]), "s", color=_TOOL, markersize=4.5)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_robot(axes: Axes, robot: RobotShape, waypoint: int, view: View) -> None:
    """Draw the robot at a waypoint as capsules, behind the human, far parts first."""
    ends, radii = robot.parts(waypoint)
    for i in np.argsort(ends.sum(axis=1) @ view.towards):
        start, end = (np.array([point @ view.across, point[2]]) for point in ends[i])
        outline = _capsule(start, end, radii[i])
        axes.fill(*outline.T, facecolor=_ROBOT, edgecolor="white", linewidth=0.6, zorder=0.5)


def fit_panels(panels: Sequence[Axes], human: Human) -> None:
    """Give panels that show a human the same limits: those of all that is drawn, and of a body standing straight."""
    stature = human.anthropometry.stature_m
    standing = Bbox([[-0.36 * stature, -0.035], [0.36 * stature, 1.04 * stature]])
    shown = Bbox.union([standing, *(panel.dataLim for panel in panels)])
    for panel in panels:
        panel.set_xlim(shown.x0 - 0.03, shown.x1 + 0.03)
        panel.set_ylim(shown.y0 - 0.025, shown.y1 + 0.035)


def draw_joint_loads(
    axes: Axes, points: Mapping[str, Vector], shares: Mapping[str, float], view: View
) -> PathCollection:
    """A disc at every compound joint, coloured by its load as share of strength (0 to 60 %)."""
    centres = np.array([points[joint.child] for joint in JOINTS])
    colours = 100 * np.array([shares[joint.name] for joint in JOINTS])
    order = np.argsort(centres @ view.towards)
    return axes.scatter(
        (centres @ view.across)[order], centres[order, 2], c=colours[order], cmap="YlOrRd", vmin=0, vmax=60, s=26,
        edgecolors="0.2", linewidths=0.6, zorder=3,
    )  # fmt: skip


def draw_load_scale(figure: Figure, axes: Sequence[Axes], discs: PathCollection, shrink: float) -> None:
    """The colours of `draw_joint_loads` explained below some panels."""
    label = "largest load at the joint, % of the maximum torque\n(blue squares: the fists that work)"
    figure.colorbar(discs, ax=list(axes), location="bottom", shrink=shrink, aspect=50, label=label, extend="max")


def _capsule(start: Vector, end: Vector, radius: float) -> Vector:
    """Outline (n, 2) of all points within `radius` of a segment."""
    along = end - start
    angle = np.arctan2(along[1], along[0])
    half = np.linspace(-np.pi / 2, np.pi / 2, 16)
    cap = radius * np.column_stack([np.cos(angle + half), np.sin(angle + half)])
    return np.vstack([end + cap, start - cap])


@house_style()
def posture_figure(
    human: Human,
    reactions: Sequence[Reaction],
    parameters: FatigueParameters,
    robots: Mapping[str, RobotShape | None] | None = None,
) -> tuple[Figure, pd.DataFrame]:
    """A worker's reactions at mid-work, joints coloured by load; landmarks and loads as data.

    `robots`: by action the arm that presents it, if there is one that can.
    """
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
            if robot := (robots or {}).get(reaction.name.action):
                work_time_s = (tick - reaction.motion.phase("work").start) * reaction.motion.time_step_s
                draw_robot(panel, robot, robot.waypoint(work_time_s), view)
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
            if clip.robot is not None:
                draw_robot(panel, clip.robot, clip.robot_waypoint(tick), SIDE)
            draw_human(panel, clip.human, points, SIDE, clip.working)
            discs = draw_joint_loads(panel, points, clip.instant(tick).joint_share, SIDE)
            set_title(panel, f"{clip.phase(tick)}, {time:g} s")
        for panel in panels[len(times) :]:
            panel.set_axis_off()
        fit_panels(panels[: len(times)], clip.human)
        title = wrapped(
            format_label(str(clip.name)) + (" (implausible)" if clip.verdict == "implausible" else ""),
            2.0,
            SETTINGS["font.size"],
        )
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

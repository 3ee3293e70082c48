"""The digital human drawn as capsules in a plane, seen from the right or from the front."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from fatigue_planner.human.model import Human
from fatigue_planner.human.skeleton import JOINTS, SIDES

Vector = NDArray[np.float64]

# (from, to, radius as a share of stature); the radii are for the eye only.
_CAPSULES = (
    ("pelvis", "abdomen", 0.062), ("abdomen", "thorax", 0.066), ("thorax", "shoulders", 0.070),
    ("neck", "head", 0.030), ("right_thigh", "left_thigh", 0.050), ("right_upper_arm", "left_upper_arm", 0.034),
    *((f"{side}_{start}", f"{side}_{end}", radius) for side in SIDES for start, end, radius in (
        ("upper_arm", "forearm", 0.024), ("forearm", "hand", 0.019), ("hand", "grip", 0.018),
        ("thigh", "shank", 0.040), ("shank", "foot", 0.028), ("heel", "toe", 0.020),
    )),
)  # fmt: skip
_BODY, _RIGHT, _TOOL = "#C9D1D9", "#9AA8B5", "#0072B2"


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
    for start, end, radius in sorted([*_CAPSULES, head], key=nearness):
        colour = _RIGHT if start.startswith("right") and end.startswith("right") else _BODY
        outline = _capsule(flat(points[start]), flat(points[end]), radius * stature)
        axes.fill(*outline.T, facecolor=colour, edgecolor="white", linewidth=0.8)
    for side in working:
        axes.plot(*flat(points[f"{side}_grip"]), "s", color=_TOOL, markersize=4.5)
    axes.set_aspect("equal")
    axes.set_axis_off()


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

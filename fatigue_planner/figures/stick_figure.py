"""The digital human drawn as capsules between its joint centres."""

import numpy as np
import pinocchio as pin
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from fatigue_planner.human.model import Human

Vector = NDArray[np.float64]

# Capsules (from, to, width in points); "hips" and "shoulders" are the middles of both sides.
_CAPSULES = (
    ("pelvis", "abdomen", 15), ("abdomen", "thorax", 17), ("thorax", "shoulders", 19), ("shoulders", "head", 6),
    ("right_upper_arm", "left_upper_arm", 9), ("right_thigh", "left_thigh", 12),
    *((f"{side}_{a}", f"{side}_{b}", width) for side in ("left", "right") for a, b, width in (
        ("upper_arm", "forearm", 7), ("forearm", "hand", 5.5), ("hand", "grip", 5),
        ("thigh", "shank", 10), ("shank", "foot", 7),
    )),
)  # fmt: skip
_BODY, _NEAR_SIDE, _TOOL = "#9AA5B1", "#52606D", "#D55E00"


def landmarks(human: Human, configuration: Vector) -> dict[str, Vector]:
    """Positions (3,) m of all frames, and the middle of the shoulders, at a configuration (46,)."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, configuration)
    points = {frame.name: data.oMf[i].translation.copy() for i, frame in enumerate(human.model.frames)}
    points["shoulders"] = (points["right_upper_arm"] + points["left_upper_arm"]) / 2
    return points


def draw_human(axes: Axes3D, human: Human, configuration: Vector) -> dict[str, Vector]:
    """Draw the human in a 3-D panel; returns its landmarks."""
    points = landmarks(human, configuration)
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, configuration)
    for start, end, width in _CAPSULES:
        line = np.array([points[start], points[end]])
        colour = _NEAR_SIDE if start.startswith("right") and end.startswith("right") else _BODY
        axes.plot(*line.T, color=colour, linewidth=width, solid_capstyle="round")
    head = data.oMf[human.model.getFrameId("head")]
    crown = head.act(np.array([0, 0, 0.07 * human.anthropometry.stature_m]))
    axes.plot(*crown[:, None], "o", color=_BODY, markersize=19)
    heel, toe, _, height = human.anthropometry.sole_rectangle()
    for side in ("left", "right"):
        foot = data.oMf[human.model.getFrameId(f"{side}_foot")]
        sole = np.array([foot.act(np.array([x, 0, height])) for x in (heel, toe)])
        axes.plot(*sole.T, color=_NEAR_SIDE if side == "right" else _BODY, linewidth=5, solid_capstyle="round")
    axes.plot(*points["right_grip"][:, None], "s", color=_TOOL, markersize=6)
    return points


def set_view(axes: Axes3D) -> None:
    """Same scale and view from the front right for every panel; the worker looks along x."""
    axes.set_xlim(-0.65, 0.75)
    axes.set_ylim(-0.7, 0.7)
    axes.set_zlim(0, 1.8)
    axes.set_box_aspect((1.4, 1.4, 1.8), zoom=1.35)
    axes.view_init(elev=8, azim=-62)
    axes.set_axis_off()

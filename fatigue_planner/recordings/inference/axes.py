"""Where up, left and forward are, and how tall a body is: by the places of known points, over all frames."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.skeleton import BODIES, JOINTS
from fatigue_planner.recordings.mapping import Place, landmark_table

Vector = NDArray[np.float64]

AXES = tuple(f"{sign}{axis}" for sign in "+-" for axis in "xyz")
# An axis is up if the body, over all frames, is along it to within this cosine (37 degrees).
CLEAR = 0.8
# A person's stature; the estimate from a few markers is good to a tenth.
STATURE_M = (1.2, 2.3)
# The first second decides where x is.
FIRST_S = 1.0
LEAST_POINTS = 4


def standing_m(places: Sequence[Place]) -> Vector:
    """Where places are (k, 3) m on somebody of the table's stature who stands straight; the pelvis is at 0."""
    person = Anthropometry(landmark_table().stature_m, 75.0, "male")  # sex and mass hardly matter to lengths
    origin = {BODIES[0]: np.zeros(3)}
    for joint in JOINTS:
        origin[joint.child] = origin[joint.parent] + person.joint_centre(joint.name)
    return np.array([origin[place.body] + place.at_m for place in places]).reshape(-1, 3)


def long_axis(position: Vector, standing: Vector) -> tuple[Vector, float] | None:
    """The direction (3,) from feet to head over all frames, and how tall the body is as a multiple of the table's.

    Positions (n, k, 3) in any unit. None if fewer than four points are known, or none of them far above another.
    """
    seen = np.asarray(np.isfinite(position).all(axis=2))
    enough = seen.sum(axis=1) >= max(LEAST_POINTS, position.shape[1] // 2)
    if not enough.any() or np.ptp(standing[:, 2]) < 0.6:
        return None
    shown, weight = np.nan_to_num(position[enough]), seen[enough].astype(float)
    height = weight * standing[:, 2]
    height -= weight * (height.sum(axis=1) / weight.sum(axis=1))[:, None]
    along = np.einsum("fk,fkc->fc", height, shown) / (height**2).sum(axis=1)[:, None]
    total = along.sum(axis=0)
    if not total.any():  # all points in one place
        return None
    return total / np.linalg.norm(total), float(np.percentile(np.linalg.norm(along, axis=1), 90))


def axis_name(direction: Vector) -> str | None:
    """The axis a direction is along; None if it is along none."""
    index = int(abs(direction).argmax())
    clear = abs(direction[index]) > CLEAR * np.linalg.norm(direction)
    return f"{'+' if direction[index] > 0 else '-'}{'xyz'[index]}" if clear else None


def upright(up: str) -> Vector:
    """The rotation (3, 3) that turns a file's axes so that z is up: with y up, z to x and x to y; with z up, none."""
    sign, axis = (1.0 if up[0] == "+" else -1.0), "xyz".index(up[1])
    rotation = np.zeros((3, 3))
    rotation[2, axis] = sign
    rotation[0, (axis + 1) % 3] = 1.0
    rotation[1, (axis + 2) % 3] = sign  # keeps it a rotation
    return rotation


def facing(position: Vector, places: Sequence[Place], rate_hz: float) -> tuple[float, bool] | None:
    """The heading in rad, from x to y, during the first second, and whether fronts and backs confirm it.

    Positions (n, k, 3), z up. None if no point has its twin on the other side.
    Raises RecordingError if backs are in front: left and right are exchanged, or the file is mirrored.
    """
    sides = {(place.landmark, place.side): index for index, place in enumerate(places)}
    lefts = [(name, index) for (name, side), index in sides.items() if side == "left"]
    pairs = [(index, sides[name, "right"]) for name, index in lefts if (name, "right") in sides]
    if not pairs:
        return None
    left = np.stack([position[:, one, :2] - position[:, other, :2] for one, other in pairs])
    total = np.nansum(left, axis=0)
    forward = np.column_stack([total[:, 1], -total[:, 0]])
    length = np.linalg.norm(forward, axis=1)
    there = length > 0
    forward[there] /= length[there, None]
    if not there.any():
        return None
    evidence = _front(position[there], places, forward[there])
    if evidence is not None and evidence < 0:
        raise RecordingError(
            "left and right are exchanged, or the file is mirrored: fronts are behind backs. If it is the labels, "
            "--exchange-sides sets them right."
        )
    first = forward[there][: max(1, int(FIRST_S * rate_hz))].sum(axis=0)
    return float(np.arctan2(first[1], first[0])), evidence is not None


def _front(position: Vector, places: Sequence[Place], forward: Vector) -> float | None:
    """How far what should be in front of its body is in front; None if no body has two such points."""
    found = []
    for body in {place.body for place in places} & {"pelvis", "thorax", "head", "right_foot", "left_foot"}:
        own = [index for index, place in enumerate(places) if place.body == body]
        ahead = np.array([places[index].at_m[0] for index in own])
        if np.ptp(ahead) > 0.08:
            shown = np.einsum("fkc,fc->fk", position[:, own, :2], forward)
            front, back = (np.nanmean(shown[:, ahead == value]) for value in (ahead.max(), ahead.min()))
            found.append(front - back)
    usable = [value for value in found if np.isfinite(value)]
    return float(np.sum(usable)) if usable else None

"""The skin of a worker: one smooth surface that follows the skeleton."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.model import Human, joint_index
from fatigue_planner.human.skeleton import BODIES, SIDES
from fatigue_planner.output.viewer.body_parts import body_parts
from fatigue_planner.output.viewer.surface import surface

Vector = NDArray[np.float64]
Faces = NDArray[np.int64]

CELL = 0.0075  # edge of the surface's grid, share of stature
_BLEND = 0.006  # width over which parts flow into each other, share of stature
_FOLLOW = 0.012  # width over which the skin follows both bodies at a joint, share of stature
_INFLUENCES = 4  # bodies a vertex follows at most
# The pose in which the skin is made: arms and legs apart, so that they do not grow together.
_APART_DEG = {"shoulder_abduction": 50.0, "hip_abduction": 14.0}


@dataclass(frozen=True)
class Skin:
    """Vertices (n, 3) m and triangles (m, 3) in a pose of the skeleton, and how they follow it.

    `weights` (n, 17) says how much a vertex follows each of `BODIES`, at most four of them, in sum 1;
    `positions` (17, 3) m and `rotations` (17, 3, 3) are the bodies' poses in which the skin was made.
    """

    vertices: Vector
    faces: Faces
    weights: Vector
    positions: Vector
    rotations: Vector


def make_skin(human: Human) -> Skin:
    """The skin of a human.

    The triangles are ordered from the ends of the limbs to the pelvis: drawn translucent in this order, a
    limb before the trunk covers it, and one behind it shines through.
    """
    configuration = pin.neutral(human.model)
    for side in SIDES:
        for name, degrees in _APART_DEG.items():
            configuration[7 + joint_index(f"{side}_{name}")] = np.radians(degrees)
    positions, rotations = body_poses(human, configuration)
    stature = human.anthropometry.stature_m
    parts = body_parts(human.anthropometry)
    sole_height = human.anthropometry.sole_rectangle()[3]
    pose = dict(zip(BODIES, zip(positions, rotations, strict=True), strict=True))

    def by_part(points: Vector) -> Vector:
        distances = np.empty((len(points), len(parts)))
        for column, part in enumerate(parts):
            position, rotation = pose[part.body]
            local = (points - position) @ rotation
            distances[:, column] = part.distance(local)
            if part.body.endswith("foot"):  # flat below
                distances[:, column] = np.maximum(distances[:, column], sole_height - local[:, 2])
        return distances

    def whole(points: Vector) -> Vector:
        return np.concatenate([_smooth_minimum(by_part(p), _BLEND * stature) for p in np.array_split(points, 40)])

    reach = 0.15 * stature
    vertices, faces = surface(whole, positions.min(axis=0) - reach, positions.max(axis=0) + reach, CELL * stature)
    nearest = by_part(vertices)
    by_body = np.column_stack([
        nearest[:, [part.body == body for part in parts]].min(axis=1) for body in BODIES
    ])  # fmt: skip
    weights = np.exp(-(by_body - by_body.min(axis=1, keepdims=True)) / (_FOLLOW * stature))
    weights[weights < np.sort(weights, axis=1)[:, [-_INFLUENCES]]] = 0
    weights /= weights.sum(axis=1, keepdims=True)
    outermost_first = np.argsort(-weights[faces].sum(axis=1).argmax(axis=1), kind="stable")
    return Skin(vertices, faces[outermost_first], weights, positions, rotations)


def body_poses(human: Human, configuration: Vector) -> tuple[Vector, Vector]:
    """Positions (17, 3) m and rotations (17, 3, 3) of `BODIES`."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, configuration)
    poses = [data.oMf[human.model.getFrameId(body)] for body in BODIES]
    return np.array([pose.translation for pose in poses]), np.array([pose.rotation for pose in poses])


def _smooth_minimum(distances: Vector, width: float) -> Vector:
    """Smallest of each row (n, k), rounded off where several are about as small; (n,)."""
    smallest = distances.min(axis=1)
    return np.asarray(smallest - width * np.log(np.exp((smallest[:, None] - distances) / width).sum(axis=1)))

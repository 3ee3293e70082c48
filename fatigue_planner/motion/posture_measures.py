"""What an observer sees of a posture: angles of trunk, head, gaze and arms, and parts of the body that meet.

All angles are in degrees, (n,) for n configurations, by forward kinematics: angles of single degrees of freedom do not
add up to what is seen.
"""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.capsule_distance import capsule_distances
from fatigue_planner.human.capsules import Capsules, capsules_of
from fatigue_planner.human.joint_data import ranges_of_motion
from fatigue_planner.human.kinematics import Poses
from fatigue_planner.human.skeleton import BODIES

Vector = NDArray[np.float64]

# How far the eyes turn down and up before the head follows, in degrees.
EYES_DOWN, EYES_UP = 20.0, 10.0
# An arm held higher has no shortest way up from hanging, in degrees from hanging.
HIGHEST = 150.0


def turn(poses: Poses, body: str, relative_to: str) -> Vector:
    """The orientation of a body in another's axes, (n, 3, 3)."""
    own, other = (poses.rotation[:, BODIES.index(name)] for name in (body, relative_to))
    return np.asarray(np.swapaxes(other, 1, 2) @ own)


def twist_about_z(rotation: Vector) -> Vector:
    """How far rotations (n, 3, 3) turn about their own z axis, beside the shortest way that this axis can take.

    The twist of the swing-twist decomposition: 2 atan2(q_z, q_w) of the quaternion, and q_z / q_w is
    (R_yx - R_xy) / (1 + trace R).
    """
    trace = rotation[:, 0, 0] + rotation[:, 1, 1] + rotation[:, 2, 2]
    return np.asarray(np.degrees(2 * np.arctan2(rotation[:, 1, 0] - rotation[:, 0, 1], 1 + trace)))


def trunk_twist(poses: Poses) -> Vector:
    """How far the chest is turned against the pelvis about its own long axis, to the left.

    Flexion, then side bend, then rotation, as the joints of the spine are: the last of the three angles.
    """
    relative = turn(poses, "thorax", "pelvis")
    return np.degrees(np.arctan2(relative[:, 1, 0], relative[:, 1, 1]))


def side_bend(poses: Poses) -> Vector:
    """How far the chest is bent sideways against the pelvis, to the right: the second of the three angles."""
    return -_arcsine(turn(poses, "thorax", "pelvis")[:, 1, 2])


def lean(poses: Poses) -> Vector:
    """Inclination of the trunk: from the middle of the hips to C7, against the vertical (ISO 11226)."""
    along = poses.origin_m[:, BODIES.index("neck")] - poses.origin_m[:, BODIES.index("pelvis")]
    return _arccosine(along[:, 2] / np.linalg.norm(along, axis=1))


def head_roll(poses: Poses) -> Vector:
    """How far the head is tilted to its right, from level."""
    return _arcsine(poses.rotation[:, BODIES.index("head"), 2, 1])


def gaze(poses: Poses, person: Anthropometry, object_m: Vector) -> Vector:
    """Between the nose and the line from the eyes to an object (n, 3) m, less what the eyes turn up or down."""
    radius = capsules_of(person).radius_m[BODIES.index("head")]
    eyes = np.array([radius, 0, person.length("eye_height") - person.origin_height("head")])
    towards = object_m - poses.points("head", eyes)
    seen = np.einsum("nij,ni->nj", poses.rotation[:, BODIES.index("head")], towards)
    seen = seen / np.linalg.norm(seen, axis=1)[:, None]
    turned = np.radians(np.clip(_arcsine(seen[:, 2]), -EYES_DOWN, EYES_UP))
    return _arccosine(np.cos(turned) * seen[:, 0] + np.sin(turned) * seen[:, 2])


def upper_arm_elevation(poses: Poses, side: str) -> Vector:
    """The upper arm against the vertical: 0 hanging, 90 level (ISO 11226)."""
    return _arccosine(poses.rotation[:, BODIES.index(f"{side}_upper_arm"), 2, 2])


def shoulder_turn(poses: Poses, side: str) -> Vector:
    """How far the upper arm is turned about its own axis beyond the range of the shoulder's rotation.

    Measured from the shortest way from hanging: with a shoulder the wrong way round, each of its three angles is in its
    range, but the humerus is turned by more than it can. 0 where the arm is raised by more than HIGHEST, as there is no
    shortest way.
    """
    relative = turn(poses, f"{side}_upper_arm", "thorax")
    medial = twist_about_z(relative) * (1 if side == "right" else -1)
    allowed = ranges_of_motion()["shoulder_rotation"]
    beyond = np.maximum(medial - allowed.max, allowed.min - medial)
    return np.asarray(np.where(_arccosine(relative[:, 2, 2]) > HIGHEST, 0.0, np.maximum(beyond, 0.0)))


def distances(poses: Poses, capsules: Capsules) -> Vector:
    """Distances (n, p) in m of the pairs of parts that may not pass through each other; negative where they do."""
    ends = capsules.world_ends(poses)
    return np.array([capsule_distances(now, capsules.radius_m, capsules.pairs)[0] for now in ends])


def _arcsine(value: Vector) -> Vector:
    return np.degrees(np.arcsin(np.clip(value, -1, 1)))


def _arccosine(value: Vector) -> Vector:
    return np.degrees(np.arccos(np.clip(value, -1, 1)))

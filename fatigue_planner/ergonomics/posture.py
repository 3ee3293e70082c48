"""The posture over a motion: the angles that ergonomic methods ask for, by forward kinematics.

Angles of single degrees of freedom are no substitute: flexion and abduction of the shoulder are Euler angles, and a
worker who turns the pelvis and leans has no side bend. Only wrist, forearm and knee are read from theirs.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.kinematics import Poses, poses_of, tree_of
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.motion import posture_measures as measures
from fatigue_planner.motion.contact import WRENCH
from fatigue_planner.motion.motion import Motion

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# A posture counts as bent backwards from here on, in degrees: people and simulations that stand upright sway by less
# (assumed; the methods give no tolerance).
BACKWARD_DEG = 5.0


@dataclass(frozen=True)
class PostureCourse:
    """The posture at n instants, `step_s` apart. Arrays are (n,), or (n, 2) for the right and left side; degrees.

    time_s            since the beginning of the reaction
    trunk_deg         line from mid-hip to C7 against the vertical; negative: leaning back by more than BACKWARD_DEG
    trunk_side_deg    chest in the pelvis, to the right
    trunk_twist_deg   chest in the pelvis, to the left
    neck_deg          head in the chest: flexion; negative: extension
    neck_side_deg     the same, to the right
    neck_twist_deg    the same, to the left
    lumbar_deg        long axis of the abdomen, next above L5/S1, against the vertical
    head_deg          head against the vertical; negative: looking up by more than BACKWARD_DEG
    arm_to_trunk_deg  upper arm from hanging along the chest; negative: backwards more than sideways
    arm_forward_deg   the same, out of the chest's frontal plane; negative: behind it
    arm_abducted_deg  the same, out of its sagittal plane; negative: towards the midline
    arm_raised_deg    upper arm against the vertical: 0 hanging, 90 level
    elbow_deg         0 is straight
    pronation_deg     forearm; negative: supination
    wrist_deg         palmar flexion; negative: dorsal
    deviation_deg     wrist, radial; negative: ulnar
    knee_deg          0 is straight
    hand_out_m        centre of the fist from the midline of the chest, outwards; negative: across the midline
    hand_m            (n, 2, 3) centre of the fist in the world: x forward in the stance, y left, z up from the ground
    ankles_m          (n, 3) middle of both ankles in the world
    foot_share        share of the ground's force on each foot; of an unloaded body one half
    speed_degps       (n,) of the fastest joint
    shoulder_half_width_m  of the worker

    Definitions: ISO 11226:2000 for trunk, head and raised arm (against the vertical), McAtamney & Corlett 1993 for arm
    and neck (against the trunk).
    """

    step_s: float
    shoulder_half_width_m: float
    time_s: Vector
    trunk_deg: Vector
    trunk_side_deg: Vector
    trunk_twist_deg: Vector
    neck_deg: Vector
    neck_side_deg: Vector
    neck_twist_deg: Vector
    lumbar_deg: Vector
    head_deg: Vector
    arm_to_trunk_deg: Matrix
    arm_forward_deg: Matrix
    arm_abducted_deg: Matrix
    arm_raised_deg: Matrix
    elbow_deg: Matrix
    pronation_deg: Matrix
    wrist_deg: Matrix
    deviation_deg: Matrix
    knee_deg: Matrix
    hand_out_m: Matrix
    hand_m: NDArray[np.float64]
    ankles_m: Matrix
    foot_share: Matrix
    speed_degps: Vector

    @classmethod
    def of(cls, person: Anthropometry, motion: Motion, step_s: float = 0.0) -> Self:
        """The posture of a motion every `step_s`, in whole ticks; at every tick by default."""
        stride = max(1, round(step_s / motion.time_step_s))
        configuration = motion.configuration[::stride]
        poses = poses_of(tree_of(person), configuration)
        angle_deg = np.degrees(configuration[:, BASE_DOF + 1 :])
        arm = [_arm(poses, side) for side in SIDES]
        hands = [poses.points(f"{side}_hand", person.grip_m()) for side in SIDES]
        neck = measures.turn(poses, "head", "thorax")
        vertical_n = motion.wrench[::stride].reshape(-1, len(SIDES), WRENCH)[:, :, 2]
        total = vertical_n.sum(axis=1, keepdims=True)
        return cls(
            step_s=stride * motion.time_step_s,
            shoulder_half_width_m=person.length("shoulder_half_width"),
            time_s=np.arange(len(configuration)) * np.float64(stride * motion.time_step_s),
            trunk_deg=_signed(measures.lean(poses), _along_trunk(poses), _forward(poses, "pelvis")),
            trunk_side_deg=measures.side_bend(poses),
            trunk_twist_deg=measures.trunk_twist(poses),
            neck_deg=np.degrees(np.arctan2(neck[:, 0, 2], neck[:, 2, 2])),
            neck_side_deg=-_arcsine(neck[:, 1, 2]),
            neck_twist_deg=np.degrees(np.arctan2(neck[:, 1, 0], neck[:, 1, 1])),
            lumbar_deg=_from_vertical(_up(poses, "abdomen")),
            head_deg=_signed(_from_vertical(_up(poses, "head")), _up(poses, "head"), _forward(poses, "head")),
            arm_to_trunk_deg=np.stack([_to_trunk(line) for line in arm], axis=1),
            arm_forward_deg=np.stack([_arcsine(line[:, 0]) for line in arm], axis=1),
            arm_abducted_deg=np.stack([_arcsine(line[:, 1]) for line in arm], axis=1),
            arm_raised_deg=np.stack([measures.upper_arm_elevation(poses, side) for side in SIDES], axis=1),
            elbow_deg=np.stack([_elbow(poses, side) for side in SIDES], axis=1),
            pronation_deg=_both(angle_deg, "forearm_pronation"),
            wrist_deg=_both(angle_deg, "wrist_flexion"),
            deviation_deg=_both(angle_deg, "wrist_deviation"),
            knee_deg=_both(angle_deg, "knee_flexion"),
            hand_out_m=np.stack(
                [_hand_out(poses, *pair) for pair in zip(hands, SIDES, strict=True)],
                axis=1,
            ),
            hand_m=np.stack(hands, axis=1),
            ankles_m=np.mean([poses.origin_m[:, BODIES.index(f"{side}_foot")] for side in SIDES], axis=0),
            foot_share=np.divide(vertical_n, total, out=np.full_like(vertical_n, 0.5), where=total > 0),
            speed_degps=np.degrees(np.abs(motion.velocity[::stride, BASE_DOF:]).max(axis=1)),
        )


def runs(taken: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where runs of what is taken (n,) begin, and where they are over: the last instant + 1."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], taken, [False]])))
    return edges[::2], edges[1::2]


def _both(angle_deg: Matrix, name: str) -> Matrix:
    return angle_deg[:, [DEGREES_OF_FREEDOM.index(f"{side}_{name}") for side in SIDES]]


def _up(poses: Poses, body: str) -> Matrix:
    """The long axis of a body in the world, (n, 3)."""
    return np.asarray(poses.rotation[:, BODIES.index(body), :, 2])


def _forward(poses: Poses, body: str) -> Matrix:
    """Where a body faces, as a level direction (n, 3): a right angle from its own left."""
    left = poses.rotation[:, BODIES.index(body), :, 1]
    return np.stack([left[:, 1], -left[:, 0], np.zeros(len(left))], axis=1)


def _along_trunk(poses: Poses) -> Matrix:
    return np.asarray(poses.origin_m[:, BODIES.index("neck")] - poses.origin_m[:, BODIES.index("pelvis")])


def _signed(inclination_deg: Vector, along: Matrix, forward: Matrix) -> Vector:
    """An inclination, negative where the line (n, 3) leans back by more than BACKWARD_DEG in the sagittal plane."""
    sagittal = np.degrees(np.arctan2(np.einsum("ni,ni->n", along, forward), along[:, 2]))
    return np.where(sagittal < -BACKWARD_DEG, -inclination_deg, inclination_deg)


def _from_vertical(line: Matrix) -> Vector:
    return np.degrees(np.arccos(np.clip(line[:, 2], -1, 1)))


def _arm(poses: Poses, side: str) -> Matrix:
    """The line from shoulder to elbow in the chest's axes, (n, 3): forward, outwards, up."""
    return _outwards(-measures.turn(poses, f"{side}_upper_arm", "thorax")[:, :, 2], side)


def _outwards(points: Matrix, side: str) -> Matrix:
    """Points (n, 3) with y away from the midline."""
    return np.asarray(points * [1.0, -1.0 if side == "right" else 1.0, 1.0])


def _hand_out(poses: Poses, hand_m: Matrix, side: str) -> Vector:
    thorax = BODIES.index("thorax")
    inside = np.einsum("nji,nj->ni", poses.rotation[:, thorax], hand_m - poses.origin_m[:, thorax])
    return _outwards(inside, side)[:, 1]


def _to_trunk(line: Matrix) -> Vector:
    elevation = np.degrees(np.arccos(np.clip(-line[:, 2], -1, 1)))
    return np.where(-line[:, 0] > np.abs(line[:, 1]), -elevation, elevation)


def _elbow(poses: Poses, side: str) -> Vector:
    upper, lower = (_up(poses, f"{side}_{body}") for body in ("upper_arm", "forearm"))
    return np.asarray(np.degrees(np.arccos(np.clip(np.einsum("ni,ni->n", upper, lower), -1, 1))))


def _arcsine(value: Vector) -> Vector:
    return np.degrees(np.arcsin(np.clip(value, -1, 1)))

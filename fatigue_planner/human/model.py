"""The digital human as a Pinocchio model, standing on the ground."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.errors import DataFileError, told_apart
from fatigue_planner.core.settings import Settings
from fatigue_planner.human.anthropometry import Anthropometry, Sex
from fatigue_planner.human.joint_data import position_limits, posture
from fatigue_planner.human.skeleton import BODIES, DEGREES_OF_FREEDOM, JOINTS, ROOT_BODY, Axis
from fatigue_planner.human.strength_sets import MAX_PATH_LENGTH

Vector = NDArray[np.float64]

GRAVITY_MPS2 = 9.81  # standard acceleration of free fall, rounded
BASE_DOF = 6
# A natural stance: soles flat to a hundredth of a millimetre, centre of mass 2 cm inside heel and toe.
STANCE_TOLERANCE = 1e-5
STANCE_MARGIN_M = 0.02

_JOINT_MODELS = {"+x": pin.JointModelRX, "+y": pin.JointModelRY, "+z": pin.JointModelRZ}
_UNIT = {"x": np.array([1.0, 0, 0]), "y": np.array([0, 1.0, 0]), "z": np.array([0, 0, 1.0])}


# The paper's: standing, arms along the body (section III-C). The angles are open; no joint rests on a limit.
NATURAL_POSTURE_DEG = {"knee_flexion": 5.0, "hip_flexion": 2.5, "ankle_flexion": 2.5, "elbow_flexion": 5.0}


class Worker(Settings):
    """A worker as an experiment describes him or her."""

    height_m: float = Field(ge=1.4, le=2.1, description="Stature in m.")
    mass_kg: float = Field(ge=40, le=150, description="Body mass in kg.")
    sex: Sex = Field(description="Decides how the mass is distributed over the segments (de Leva 1996).")
    strength: str = Field(
        default_factory=lambda worker: "average_woman" if worker.get("sex") == "female" else "average_man",
        min_length=1,
        max_length=MAX_PATH_LENGTH,
        description="Maximum joint torques in N.m: the name of a set that ships with fatplan, or a YAML file. "
        "Default: the average man's or woman's, by sex.",
    )
    natural_posture_deg: dict[str, float] = Field(
        default=NATURAL_POSTURE_DEG,
        description="Stance in which every cycle begins and to which all joints are drawn: angles in degrees by degree "
        "of freedom, the rest 0; a name without right_ or left_ means both sides.",
    )


class Tool(Settings):
    """A hand tool: a point mass at the centre of a fist.

    hand: the hand that holds it. Left out, it is the hand that works; where both do, the right one, as in the paper.
    """

    mass_kg: float = Field(ge=0, le=30, description="Mass of the tool in kg; the paper's is 5 kg (section IV-A).")
    held: Literal["cycle", "work"] = Field(
        default="cycle", description="Whether the tool is in the hand during the whole cycle or only during work."
    )
    hand: Literal["right", "left"] | None = Field(
        default=None,
        description="Hand that holds the tool; it must have a goal in every action. Default: the hand that works, or "
        "the right one where both do.",
    )


@dataclass(frozen=True)
class Human:
    """A Pinocchio model of a worker and what the controller needs to know of it.

    Joint vectors hold the 39 degrees of freedom in the order of `skeleton.DEGREES_OF_FREEDOM`;
    configurations (46,) put position and quaternion (x, y, z, w) of the pelvis before them,
    velocities (45,) the pelvis' twist in its own frame. The world's origin is on the ground, at the
    centre between the two soles. Frames: one per body, named after it, `<side>_grip` at the centre of
    each fist and `<side>_sole` at the centre of each sole.
    """

    model: pin.Model
    anthropometry: Anthropometry
    stance: Vector
    sole_half_length_m: float
    sole_half_breadth_m: float

    @property
    def mass_kg(self) -> float:
        """Total mass, with what the hands hold."""
        return float(pin.computeTotalMass(self.model))


def _joint_model(axis: Axis) -> pin.JointModel:
    if axis in _JOINT_MODELS:
        return _JOINT_MODELS[axis]()
    return pin.JointModelRevoluteUnaligned(-_UNIT[axis[1]])


def _tree(body: Anthropometry) -> pin.Model:
    model = pin.Model()
    model.name = "human"
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY_MPS2])
    joint_of = {ROOT_BODY: model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")}
    for joint in JOINTS:
        placement = pin.SE3(np.eye(3), body.joint_centre(joint.name))
        parent = joint_of[joint.parent]
        for dof in joint.degrees_of_freedom:
            parent = model.addJoint(parent, _joint_model(dof.axis), placement, dof.name)
            placement = pin.SE3.Identity()
        joint_of[joint.child] = parent
    for name in BODIES:
        segment = body.segment(name)
        inertia = pin.Inertia(segment.mass_kg, segment.com_m, np.diag(segment.inertia_kgm2))
        model.appendBodyToJoint(joint_of[name], inertia, pin.SE3.Identity())
        _add_frame(model, name, joint_of[name], np.zeros(3))
    heel, toe, _, height = body.sole_rectangle()
    for side in ("right", "left"):
        _add_frame(model, f"{side}_grip", joint_of[f"{side}_hand"], body.grip_m())
        _add_frame(model, f"{side}_sole", joint_of[f"{side}_foot"], np.array([(heel + toe) / 2, 0.0, height]))
    lower, upper = position_limits()
    model.lowerPositionLimit[7:] = lower
    model.upperPositionLimit[7:] = upper
    return model


def _add_frame(model: pin.Model, name: str, joint: int, offset_m: Vector) -> None:
    model.addFrame(pin.Frame(name, joint, pin.SE3(np.eye(3), offset_m), pin.FrameType.OP_FRAME))


def stand(model: pin.Model, joint_angles: Vector) -> Vector:
    """The configuration (46,) with these joint angles whose soles rest on the ground about the origin.

    The right sole lies flat; the midpoint of both soles is the world's origin, x forward.
    """
    data = model.createData()
    configuration = np.concatenate([[0, 0, 0, 0, 0, 0, 1.0], joint_angles])
    pin.framesForwardKinematics(model, data, configuration)
    right = data.oMf[model.getFrameId("right_sole")]
    left = data.oMf[model.getFrameId("left_sole")]
    middle = pin.SE3(right.rotation, (right.translation + left.translation) / 2)
    configuration[:7] = pin.SE3ToXYZQUAT(middle.inverse())
    return configuration


def build_human(worker: Worker, right_hand_kg: float = 0.0, left_hand_kg: float = 0.0) -> Human:
    """The digital human of a worker, with point masses in the fists.

    Raises DataFileError if the natural posture names an unknown degree of freedom, leaves a range of
    motion or does not stand on flat soles.
    """
    body = Anthropometry(worker.height_m, worker.mass_kg, worker.sex)
    model = _tree(body)
    for side, mass in (("right", right_hand_kg), ("left", left_hand_kg)):
        if mass > 0:
            grip = model.frames[model.getFrameId(f"{side}_grip")]
            model.appendBodyToJoint(grip.parentJoint, pin.Inertia(mass, np.zeros(3), np.zeros((3, 3))), grip.placement)
    heel, toe, half_breadth, _ = body.sole_rectangle()
    stance = stand(model, posture(worker.natural_posture_deg, "natural_posture_deg"))
    human = Human(model, body, stance, (toe - heel) / 2, half_breadth)
    _check_stance(human)
    return human


def _check_stance(human: Human) -> None:
    """Raise DataFileError unless both soles lie flat and the centre of mass is well above them."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, human.stance)
    for side in ("right", "left"):
        sole = data.oMf[human.model.getFrameId(f"{side}_sole")]
        if abs(sole.translation[2]) > STANCE_TOLERANCE or 1 - sole.rotation[2, 2] > STANCE_TOLERANCE:
            raise DataFileError(
                f"natural_posture_deg: the {side} sole does not lie flat on the ground; bend both legs alike, or so "
                "that their soles meet the ground together."
            )
    forward = float(pin.centerOfMass(human.model, data, human.stance)[0])
    farthest = human.sole_half_length_m - STANCE_MARGIN_M
    if abs(forward) > farthest:
        away, allowed = told_apart(100 * abs(forward), 100 * farthest, ".1f")
        raise DataFileError(
            f"natural_posture_deg: the body leans, its centre of mass is {away} cm "
            f"{'in front of' if forward > 0 else 'behind'} the middle of the soles (allowed: {allowed} cm). Upright "
            "legs have hip_flexion = knee_flexion - ankle_flexion, e.g. 2.5, 5 and 2.5."
        )


def joint_index(name: str) -> int:
    """Index of a degree of freedom in a joint vector."""
    return DEGREES_OF_FREEDOM.index(name)

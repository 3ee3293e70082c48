"""The bodies and joints of a worker as a Pinocchio model, and how he stands on the ground."""

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.joint_data import position_limits
from fatigue_planner.human.skeleton import BODIES, JOINTS, ROOT_BODY, Axis

Vector = NDArray[np.float64]

GRAVITY_MPS2 = 9.81  # standard acceleration of free fall, rounded
BASE_DOF = 6

_JOINT_MODELS = {"+x": pin.JointModelRX, "+y": pin.JointModelRY, "+z": pin.JointModelRZ}
_UNIT = {"x": np.array([1.0, 0, 0]), "y": np.array([0, 1.0, 0]), "z": np.array([0, 0, 1.0])}


def _joint_model(axis: Axis) -> pin.JointModel:
    if axis in _JOINT_MODELS:
        return _JOINT_MODELS[axis]()
    return pin.JointModelRevoluteUnaligned(-_UNIT[axis[1]])


def multibody(body: Anthropometry) -> pin.Model:
    """The model of a body of these lengths and masses, with empty hands; see `model.Human`."""
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

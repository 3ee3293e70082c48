"""Torques of the simulated reactions at mid-work against the literature's bands."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.model import Human, joint_index
from fatigue_planner.human.skeleton import JOINTS
from fatigue_planner.output.reports.human.markdown import (
    deviation_from,
    interval,
    noteworthy,
    number,
    outside,
    signed_percent,
    table,
    verdict,
)
from fatigue_planner.output.reports.human.postures import JOINT_NAMES, lifting_torques_nm
from fatigue_planner.output.reports.human.references import LoadedJoint, Target, references
from fatigue_planner.reactions.reaction import Reaction

Vector = NDArray[np.float64]

THREE_AXES = ("back", "shoulder")
SAME_PLACE_M = 0.02  # a fist this near to a reference target is at it
SAME_MASS_KG = 0.01
_COMPOUND: dict[LoadedJoint, str] = {
    "back": "lumbar",
    "shoulder": "right_shoulder",
    "elbow": "right_elbow",
    "wrist": "right_wrist",
}
_JOINTS = {joint: next(found for found in JOINTS if found.name == name) for joint, name in _COMPOUND.items()}


@dataclass(frozen=True)
class MidWork:
    """A reaction in the middle of its work; torques in N.m by joint.

    `lifting_nm`: of the degree of freedom that lifts; `together_nm`: Euclidean norm of the torques of the
    joint's degrees of freedom; `moment_nm`: of the moment the joint transmits, moving and at rest;
    `fist_before_m`: horizontal distance of the right fist from the joint.
    """

    lifting_nm: dict[LoadedJoint, float]
    together_nm: dict[LoadedJoint, float]
    moment_nm: dict[LoadedJoint, float]
    moment_at_rest_nm: dict[LoadedJoint, float]
    fist_before_m: dict[LoadedJoint, float]
    target: Target | None


def mid_work(human: Human, tool_mass_kg: float, reaction: Reaction) -> MidWork:
    """What a reaction costs in the middle of its work; `human` holds the tool."""
    motion = reaction.motion
    tick = motion.middle("work")
    configuration = motion.configuration[tick]
    rest = np.zeros(human.model.nv)
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, configuration)
    fist = data.oMf[human.model.getFrameId("right_grip")].translation
    before = {
        joint: float(np.linalg.norm((fist - data.oMf[human.model.getFrameId(compound.child)].translation)[:2]))
        for joint, compound in _JOINTS.items()
    }
    together = {
        joint: float(
            np.linalg.norm([motion.torque_nm[tick, joint_index(dof.name)] for dof in compound.degrees_of_freedom])
        )
        for joint, compound in _JOINTS.items()
    }
    return MidWork(
        lifting_torques_nm(motion.torque_nm[tick]),
        together,
        _moments_nm(human, configuration, motion.velocity[tick], motion.acceleration[tick]),
        _moments_nm(human, configuration, rest, rest),
        before,
        _target(fist, tool_mass_kg),
    )


def _moments_nm(
    human: Human, configuration: Vector, velocity: Vector, acceleration: Vector
) -> dict[LoadedJoint, float]:
    """Magnitude of the moment each joint transmits about its centre, all axes together, N.m."""
    data = human.model.createData()
    pin.rnea(human.model, data, configuration, velocity, acceleration)
    first = {joint: human.model.getJointId(compound.degrees_of_freedom[0].name) for joint, compound in _JOINTS.items()}
    return {joint: float(np.linalg.norm(data.f[place].angular)) for joint, place in first.items()}


def _target(fist_m: Vector, tool_mass_kg: float) -> Target | None:
    """The paper's target the right fist is at with the paper's tool, if it is at one."""
    for target in references().targets:
        near = np.linalg.norm(fist_m - np.array(target.position_m)) < SAME_PLACE_M
        if near and abs(target.tool_mass_kg - tool_mass_kg) < SAME_MASS_KG:
            return target
    return None


def reactions_section(human: Human, tool_mass_kg: float, reactions: Sequence[Reaction]) -> str:
    """Torques of every reaction at mid-work; those at the paper's targets have a band.

    `human` holds the tool that the reactions were simulated with.
    """
    rows, inside, hidden = [], {}, {}
    for reaction in reactions:
        middle = mid_work(human, tool_mass_kg, reaction)
        for joint, moment in middle.moment_nm.items():
            before = middle.fist_before_m[joint]
            band = middle.target.band if middle.target and middle.target.joint == joint else None
            if band:
                label = f"{reaction.name}, {JOINT_NAMES[joint]}, {number(moment, 0)} N·m"
                off = signed_percent(deviation_from(moment, band))
                inside[f"{label} ({off}; the fist is {number(100 * before, 0)} cm before it)"] = (
                    verdict(moment, band) == "inside"
                )
            if joint in THREE_AXES:
                hidden[f"{reaction.name}, {JOINT_NAMES[joint]}"] = middle.together_nm[joint] / moment - 1
            torques = (middle.lifting_nm[joint], middle.together_nm[joint], moment, middle.moment_at_rest_nm[joint])
            rows.append(
                [
                    str(reaction.name), JOINT_NAMES[joint], *(number(torque, 0) for torque in torques),
                    number(100 * before, 0), interval(band, 0), verdict(moment, band),
                ]
            )  # fmt: skip
    header = ["reaction", "joint", "lifting torque, N·m", "torques together, N·m", "moment, N·m", "at rest, N·m"]
    return "\n\n".join(
        [
            "## Torques of the simulated reactions at mid-work",
            table([*header, "fist before the joint, cm", "band, N·m", "verdict"], rows),
            "The lifting torque is that of one degree of freedom (extension of L5/S1, flexion of shoulder and elbow, "
            "radial deviation of the wrist); “together” is the root of the sum of squares over the joint's degrees of "
            "freedom, the ones the fatigue model sees; the moment is the whole one the joint transmits, and what "
            "the bands are of. The bands were calculated with an upright trunk and the fist 50 cm before the shoulder "
            "at the high target, and a planar trunk and the fist 52 cm before L5/S1 at the low one.",
            outside("the bands", inside) if inside else "No reaction is at one of the paper's targets with 5 kg.",
            noteworthy("the moment (torques together, joints with three axes)", hidden)
            + " Axes that follow each other are not perpendicular in every posture; a moment between them then shows "
            "only in part as torques.",
            references().cite("plausibility"),
        ]
    )

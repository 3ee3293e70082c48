"""Tables of torques: static ones in given postures, and those of the simulated reactions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.core.text import fixed, signed_percent
from fatigue_planner.human.joint_data import posture
from fatigue_planner.human.model import Human, Worker, build_human, joint_index
from fatigue_planner.human.multibody import BASE_DOF, stand
from fatigue_planner.human.skeleton import JOINTS
from fatigue_planner.motion.schedule import runs_of, tool_hand
from fatigue_planner.motion.settings import Side
from fatigue_planner.output.reports.human.hand_calculation import static_moments_nm
from fatigue_planner.output.reports.human.references import (
    Interval,
    LoadedJoint,
    ReferencePosture,
    Target,
    references,
)
from fatigue_planner.output.reports.human.tables import NONE, SourcedTable, deviation_from, interval, verdict
from fatigue_planner.reactions.reaction import Reaction

Vector = NDArray[np.float64]


class Joint(NamedTuple):
    """A joint of the tables of torques: its name there, the model's, and which torque of it lifts, with its sign.

    Those of the arm are the right one's; `of_side` gives the left one's.
    """

    label: str
    compound: str
    lifting: str
    sign: float

    def of_side(self, side: Side) -> "Joint":
        """The same joint of the arm of a side."""
        return self._replace(
            compound=self.compound.replace("right_", f"{side}_"), lifting=self.lifting.replace("right_", f"{side}_")
        )


LOADED: dict[LoadedJoint, Joint] = {
    "back": Joint("L5/S1", "lumbar", "lumbar_flexion", -1.0),
    "shoulder": Joint("shoulder", "right_shoulder", "right_shoulder_flexion", 1.0),
    "elbow": Joint("elbow", "right_elbow", "right_elbow_flexion", 1.0),
    "wrist": Joint("wrist", "right_wrist", "right_wrist_deviation", 1.0),
}
_COMPOUNDS = {joint.name: joint for joint in JOINTS}
THREE_AXES = ("back", "shoulder")
AT_TARGET_M = 0.02  # a fist this near to a reference target is at it
SAME_MASS_KG = 0.01


def lifting_torque_nm(joint: Joint, torque_nm: Vector) -> float:
    """The lifting torque of a joint among joint torques (39,) in N.m."""
    return float(joint.sign * torque_nm[joint_index(joint.lifting)])


def model_torques_nm(worker: Worker, wanted: ReferencePosture) -> dict[LoadedJoint, float]:
    """The model's lifting torques at rest in a posture, N.m.

    The pelvis carries the weight here, the feet in reality: without a difference for back and arms, whose
    torques do not depend on where the body is held below them.
    """
    model = build_human(worker, wanted.tool_mass_kg).model
    rest, configuration = np.zeros(model.nv), stand(model, posture(wanted.angles_deg, "angles_deg"))
    torque_nm = pin.rnea(model, model.createData(), configuration, rest, rest)[BASE_DOF:]
    return {name: lifting_torque_nm(joint, torque_nm) for name, joint in LOADED.items()}


def postures(worker: Worker, human: Human) -> tuple[SourcedTable, Mapping[str, float]]:
    """Torques of the model in every reference posture beside sums and bands; its deviations from those by hand."""
    header = ["posture", "joint", "model, N·m", "by hand, N·m", "deviation", "expected, N·m", "deviation", "band, N·m"]
    table, from_hand = SourcedTable([*header, "verdict"], cited=["de_leva", "plausibility"]), {}
    for name, wanted in references().postures.items():
        model = model_torques_nm(worker, wanted)
        by_hand = static_moments_nm(human.anthropometry, wanted.angles_deg, wanted.tool_mass_kg)
        for joint in wanted.joints:
            label = f"{name}: {LOADED[joint].label}"
            band, expected = wanted.bands.get(joint), wanted.expected.get(joint)
            from_hand[label] = model[joint] / by_hand[joint] - 1
            if expected:
                table.deviations[label] = deviation_from(model[joint], expected)
            if band:
                table.inside[label] = band[0] <= model[joint] <= band[1]
            table.rows.append(
                [
                    name, LOADED[joint].label, fixed(model[joint]), fixed(by_hand[joint]),
                    signed_percent(from_hand[label]), interval(expected),
                    signed_percent(table.deviations[label]) if expected else NONE, interval(band, 0),
                    verdict(model[joint], band),
                ]
            )  # fmt: skip
    return table, from_hand


@dataclass(frozen=True)
class JointLoad:
    """What a joint bears in the middle of a reaction's work; torques in N.m.

    `lifting_nm`: of the degree of freedom that lifts; `together_nm`: Euclidean norm of the torques of the
    joint's degrees of freedom; `moment_nm`: of the moment the joint transmits about its centre, moving and
    at rest; `fist_before_m`: horizontal distance of the fist that works from the joint; `band`: where the
    paper's target has one for this joint.
    """

    lifting_nm: float
    together_nm: float
    moment_nm: float
    moment_at_rest_nm: float
    fist_before_m: float
    band: Interval | None


def mid_work(reaction: Reaction) -> dict[LoadedJoint, JointLoad]:
    """What a reaction costs in the middle of its work, the arm being the one that holds the tool, or would."""
    motion, request = reaction.motion, reaction.key.motion_request()
    tick, side = motion.middle("work"), tool_hand(request.tool, request.action)
    runs = runs_of(request.tool, request.action, motion.phases)
    run = next(run for run in runs if run.start <= tick < run.stop)
    model = run.human(request.worker).model
    rest = np.zeros(model.nv)
    moving, still = model.createData(), model.createData()
    pin.rnea(model, moving, motion.configuration[tick], motion.velocity[tick], motion.acceleration[tick])
    pin.rnea(model, still, motion.configuration[tick], rest, rest)
    pin.framesForwardKinematics(model, still, motion.configuration[tick])
    fist = still.oMf[model.getFrameId(f"{side}_grip")].translation
    target, loads = _target(fist, request.tool.mass_kg), {}
    for name, right in LOADED.items():
        joint = right.of_side(side)
        compound = _COMPOUNDS[joint.compound]
        dofs = [dof.name for dof in compound.degrees_of_freedom]
        first = model.getJointId(dofs[0])
        centre = still.oMf[model.getFrameId(compound.child)].translation
        loads[name] = JointLoad(
            lifting_torque_nm(joint, motion.torque_nm[tick]),
            float(np.linalg.norm([motion.torque_nm[tick, joint_index(dof)] for dof in dofs])),
            float(np.linalg.norm(moving.f[first].angular)),
            float(np.linalg.norm(still.f[first].angular)),
            float(np.linalg.norm((fist - centre)[:2])),
            target.band if target and target.joint == name else None,
        )
    return loads


def _target(fist_m: Vector, tool_mass_kg: float) -> Target | None:
    """The paper's target a fist is at with the paper's tool, if it is at one."""
    for target in references().targets:
        near = np.linalg.norm(fist_m - np.array(target.position_m)) < AT_TARGET_M
        if near and abs(target.tool_mass_kg - tool_mass_kg) < SAME_MASS_KG:
            return target
    return None


def reaction_torques(reactions: Sequence[Reaction]) -> SourcedTable:
    """Torques of every reaction at mid-work, those at the paper's targets with their bands.

    The deviations are of the torques together from the moment.
    """
    header = ["reaction", "joint", "lifting torque, N·m", "torques together, N·m", "moment, N·m", "at rest, N·m"]
    table = SourcedTable([*header, "fist in front of the joint, cm", "band, N·m", "verdict"], cited=["plausibility"])
    for reaction in reactions:
        for name, load in mid_work(reaction).items():
            label, moment, before = f"{reaction.name}, {LOADED[name].label}", load.moment_nm, 100 * load.fist_before_m
            if load.band:
                off = signed_percent(deviation_from(moment, load.band))
                what = f"{label}, {fixed(moment, 0)} N·m ({off}; the fist is {fixed(before, 0)} cm in front of it)"
                table.inside[what] = load.band[0] <= moment <= load.band[1]
            if name in THREE_AXES:
                table.deviations[label] = load.together_nm / moment - 1
            numbers = (load.lifting_nm, load.together_nm, moment, load.moment_at_rest_nm, before)
            cells = [*(fixed(number, 0) for number in numbers), interval(load.band, 0), verdict(moment, load.band)]
            table.rows.append([str(reaction.name), LOADED[name].label, *cells])
    return table

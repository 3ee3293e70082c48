"""Static torques in given postures: the model, a calculation by hand, and what was expected."""

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.joint_data import posture
from fatigue_planner.human.model import BASE_DOF, Human, Worker, build_human, joint_index, stand
from fatigue_planner.output.reports.human.hand_calculation import static_moments_nm
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
from fatigue_planner.output.reports.human.references import LoadedJoint, ReferencePosture, references

Vector = NDArray[np.float64]

# Degree of freedom and sign of the torque that lifts (see `static_moments_nm`).
LIFTING: dict[LoadedJoint, tuple[str, float]] = {
    "back": ("lumbar_flexion", -1.0),
    "shoulder": ("right_shoulder_flexion", 1.0),
    "elbow": ("right_elbow_flexion", 1.0),
    "wrist": ("right_wrist_deviation", 1.0),
}
JOINT_NAMES: dict[LoadedJoint, str] = {"back": "L5/S1", "shoulder": "shoulder", "elbow": "elbow", "wrist": "wrist"}


def lifting_torques_nm(torque_nm: Vector) -> dict[LoadedJoint, float]:
    """The lifting torques among joint torques (39,) in N.m."""
    return {joint: float(sign * torque_nm[joint_index(freedom)]) for joint, (freedom, sign) in LIFTING.items()}


def torques_at_rest_nm(human: Human, configuration: Vector) -> Vector:
    """Joint torques (39,) at rest, N.m.

    The pelvis carries the weight here, the feet in reality: without a difference for back and arms, whose
    torques do not depend on where the body is held below them.
    """
    rest = np.zeros(human.model.nv)
    return np.asarray(pin.rnea(human.model, human.model.createData(), configuration, rest, rest)[BASE_DOF:])


def model_torques_nm(worker: Worker, wanted: ReferencePosture) -> dict[LoadedJoint, float]:
    """The model's lifting torques in a posture."""
    human = build_human(worker, wanted.tool_mass_kg)
    return lifting_torques_nm(torques_at_rest_nm(human, stand(human.model, posture(wanted.angles_deg, "angles_deg"))))


def postures_section(worker: Worker) -> str:
    """Torques of the model in every reference posture, beside the hand calculation, sums and bands."""
    body = build_human(worker).anthropometry
    rows, by_hand_off, expected_off, inside = [], {}, {}, {}
    for name, wanted in references().postures.items():
        model = model_torques_nm(worker, wanted)
        by_hand = static_moments_nm(body, wanted.angles_deg, wanted.tool_mass_kg)
        for joint in wanted.joints:
            label = f"{name}: {JOINT_NAMES[joint]}"
            band, expected = wanted.bands.get(joint), wanted.expected.get(joint)
            off = deviation_from(model[joint], expected) if expected else None
            by_hand_off[label] = model[joint] / by_hand[joint] - 1
            if off is not None:
                expected_off[label] = off
            if band:
                inside[label] = band[0] <= model[joint] <= band[1]
            rows.append(
                [
                    name, JOINT_NAMES[joint], number(model[joint]), number(by_hand[joint]),
                    signed_percent(by_hand_off[label]), interval(expected), signed_percent(off), interval(band, 0),
                    verdict(model[joint], band),
                ]
            )  # fmt: skip
    header = ["posture", "joint", "model, N·m", "by hand, N·m", "deviation", "expected, N·m", "deviation"]
    return "\n\n".join(
        [
            "## Static torques in given postures",
            table([*header, "band, N·m", "verdict"], rows),
            "“By hand” is a sum of weights times horizontal distances from the segment table, in plane trigonometry, "
            "without the rigid-body library [C]. “Expected” and the bands are sums made before the model was built, "
            "by other assumptions: the load at the hand's centre of mass (the model: at the fist's centre, 8.7 cm "
            "beyond the wrist), other elbow angles. Torques lift: extension of L5/S1, flexion of shoulder and elbow, "
            "radial deviation of the wrist.",
            noteworthy("the calculation by hand", by_hand_off) + " " + noteworthy("what was expected", expected_off),
            outside("the bands", inside),
            references().cite("de_leva", "plausibility"),
        ]
    )

"""The stance of each human: standing, arms along the body (paper, section III-C). Its angles are open.

The paper's human stands slightly off his straight knees, which would rest on the end of their range. The natural human
stands as little tired as he can: his weight and his passive joint moments balance, and his arms clear his body.
"""

from functools import cache

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.capsule_distance import capsule_distances
from fatigue_planner.human.capsules import capsules_of
from fatigue_planner.human.joint_data import degrees_of_freedom, maximum_torque, posture
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.multibody import BASE_DOF, GRAVITY_MPS2, multibody, stand
from fatigue_planner.human.passive_moments import passive_moments_of
from fatigue_planner.human.skeleton import SIDES

Vector = NDArray[np.float64]

PAPER_DEG = {"knee_flexion": 5.0, "hip_flexion": 2.5, "ankle_flexion": 2.5, "elbow_flexion": 5.0}

# Just off the straight knee and elbow (assumed).
KNEE_DEG = ELBOW_DEG = 5.0
# The joints that carry the standing body.
CARRYING = ("ankle_flexion", "knee_flexion", "hip_flexion", "lumbar_flexion")
# A pelvis tilted by a degree is as unwelcome as a load of so much of the strength (assumed).
TILT_SHARE_PER_DEG = 0.02
# The arms are held away from the body until they are not in it any more, but by no more than MAX_ABDUCTION_DEG.
ABDUCTION_STEP_DEG, MAX_ABDUCTION_DEG = 0.5, 10.0
ITERATIONS, DIFFERENCE_DEG = 4, 1e-3


@cache
def stance_deg(person: Anthropometry) -> dict[str, float]:
    """The angles of the stance in degrees by degree of freedom, the rest 0."""
    if person.human == "paper":
        return PAPER_DEG
    arms = {"elbow_flexion": ELBOW_DEG, "shoulder_abduction": _abduction_deg(person)}
    return _balanced_legs(person, arms) | arms


def _abduction_deg(person: Anthropometry) -> float:
    """The least abduction at which the arms are not in the body, or else the one that keeps them farthest apart.

    The upper arm may touch the chest beside the shoulder.
    """
    model, tree, capsules = multibody(person), tree_of(person), capsules_of(person)
    pairs = capsules.pairs[~capsules.joined]
    angles = np.arange(0.0, MAX_ABDUCTION_DEG + ABDUCTION_STEP_DEG, ABDUCTION_STEP_DEG)
    nearest = []
    for angle in angles:
        arms = {"elbow_flexion": ELBOW_DEG, "shoulder_abduction": float(angle)}
        configuration = stand(model, posture(arms, "stance"))
        ends = capsules.world_ends(poses_of(tree, configuration[None]))[0]
        nearest.append(capsule_distances(ends, capsules.radius_m, pairs)[0].min())
        if nearest[-1] >= 0:
            return float(angle)
    return float(angles[int(np.argmax(nearest))])


def _balanced_legs(person: Anthropometry, arms: dict[str, float]) -> dict[str, float]:
    """Angles of the legs that minimise the sum of squared loads of the carrying joints, and of the pelvis' tilt."""
    model = multibody(person)
    strength = np.maximum(*maximum_torque("average_woman" if person.sex == "female" else "average_man").vectors())
    carrying = [index for name in CARRYING for index in degrees_of_freedom(name)]

    def legs(bent: Vector) -> dict[str, float]:
        ankle, hip = (float(angle) for angle in bent)
        return {"knee_flexion": KNEE_DEG, "hip_flexion": hip, "ankle_flexion": ankle}

    def load(bent: Vector) -> Vector:
        muscles = muscles_in_stance_nm(person, model, stand(model, posture(legs(bent) | arms, "stance")))
        return np.append((muscles / strength)[carrying], TILT_SHARE_PER_DEG * (bent.sum() - KNEE_DEG))

    bent = np.array([KNEE_DEG, 0.0])
    for _ in range(ITERATIONS):  # Gauss and Newton
        here = load(bent)
        slopes = np.column_stack([(load(bent + step) - here) / DIFFERENCE_DEG for step in DIFFERENCE_DEG * np.eye(2)])
        bent = bent - np.linalg.lstsq(slopes, here, rcond=None)[0]
    return legs(np.round(bent, 1))


def muscles_in_stance_nm(person: Anthropometry, model: pin.Model, configuration: Vector) -> Vector:
    """What muscles exert (39,) N.m when the body stands still on both feet alike, beside its passive moments."""
    data = model.createData()
    torque: Vector = pin.computeGeneralizedGravity(model, data, configuration).copy()
    forward = pin.centerOfMass(model, data, configuration)[0]
    pin.computeJointJacobians(model, data, configuration)
    pin.updateFramePlacements(model, data)
    half = pin.computeTotalMass(model) * GRAVITY_MPS2 / 2
    for side in SIDES:
        sole = model.getFrameId(f"{side}_sole")
        ahead = forward - data.oMf[sole].translation[0]
        jacobian = pin.getFrameJacobian(model, data, sole, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        torque -= np.array([0, 0, half, 0, -ahead * half, 0]) @ jacobian
    return torque[BASE_DOF:] - passive_moments_of(person, configuration[7:])

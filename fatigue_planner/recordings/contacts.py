"""What carries a person beside the plates, and that nobody measured: a chair, a table, an object in the hands."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.recordings.dynamics import Movement, Torques
from fatigue_planner.recordings.kinematics.tracking import longest_run

Vector = NDArray[np.float64]

# There is one where the force that no plate explains is such a share of the weight for so long, and as far as it is
# half of that (assumed; good recordings leave 3 %).
CONTACT_SHARE, CONTACT_S = 0.1, 0.1


@dataclass(frozen=True)
class Contact:
    """Something that carries a person and that nobody measured, such as a chair.

    start_s, end_s: when; force_n (3,): its mean; body: the one past which it goes nearest.
    """

    start_s: float
    end_s: float
    force_n: Vector
    body: str


def unmeasured_contacts(model: pin.Model, motion: Movement, torques: Torques) -> list[Contact]:
    """What carries the person beside the plates; none if nothing was measured.

    Torques of the legs, the back and all that it loads are
    not to be believed meanwhile.
    """
    weight = pin.computeTotalMass(model) * GRAVITY_MPS2
    size = np.nan_to_num(np.linalg.norm(torques.residual_force_n, axis=1)) / weight
    edges = np.flatnonzero(np.diff(np.concatenate([[False], size > CONTACT_SHARE / 2, [False]]).astype(int)))
    contacts = []
    for start, end in edges.reshape(-1, 2):
        if longest_run(size[start:end] > CONTACT_SHARE) >= CONTACT_S * motion.rate_hz:
            own = slice(start, end)
            body = _nearest(
                model, motion.configuration[own], torques.residual_force_n[own], torques.residual_moment_nm[own]
            )
            force = torques.residual_force_n[own].mean(axis=0)
            contacts.append(Contact(float(start / motion.rate_hz), float((end - 1) / motion.rate_hz), force, body))
    return contacts


def _nearest(model: pin.Model, configuration: Vector, force_n: Vector, moment_nm: Vector) -> str:
    """The body whose frame is nearest to the lines along which forces act, given with moments about the mid-hip."""
    data = model.createData()
    strength = np.linalg.norm(force_n, axis=1)
    away = np.zeros(len(BODIES))
    for n in np.argsort(-strength)[: max(1, len(strength) // 2)]:
        pin.framesForwardKinematics(model, data, configuration[n])
        along, middle = force_n[n] / strength[n], configuration[n, :3]
        foot = np.cross(force_n[n], moment_nm[n]) / strength[n] ** 2
        for index, body in enumerate(BODIES):
            off = data.oMf[model.getFrameId(body)].act(_middle(model, body)) - middle - foot
            away[index] += float(np.linalg.norm(off - along * (along @ off)))
    return BODIES[int(away.argmin())]


def _middle(model: pin.Model, body: str) -> Vector:
    """A body's mass centre in its frame, (3,) m."""
    return np.asarray(model.inertias[model.frames[model.getFrameId(body)].parentJoint].lever)

"""What carries a recorded person: the wrenches on the soles, which foot is on which plate, and what nobody measured."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.core.text import percent
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import BODIES, SIDES
from fatigue_planner.motion.contact import WRENCH
from fatigue_planner.recordings import dynamics
from fatigue_planner.recordings.content import Remark
from fatigue_planner.recordings.dynamics import LEAST_N, RAISED_M, Movement, Torques
from fatigue_planner.recordings.kinematics.measured import Measured
from fatigue_planner.recordings.kinematics.tracking import longest_run
from fatigue_planner.recordings.recording import GroundForce

Vector = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Something unmeasured carries where the force that no plate explains is such a share of the weight for so long, and as
# far as it is half of that (assumed; good recordings leave 3 %).
CONTACT_SHARE, CONTACT_S = 0.1, 0.1
# Lags are looked for up to here, told from there on, and known where both forces are so alike (correlation; assumed).
LONGEST_LAG_S, LEAST_LAG_S, ALIKE = 0.25, 0.01, 0.7
LEAST_CHANGE_N = 0.1  # of the force (SD)
TOLD_SHARE = 0.01  # of the time; what is rarer is not told


@dataclass(frozen=True)
class Contact:
    """Something that carries a person and that nobody measured: a chair, a table, an object in the hands.

    start, stop: its frames [start, stop); force_n (3,): its mean; body: the one past which it goes nearest.
    """

    start: int
    stop: int
    force_n: Vector
    body: str


def soles_m(person: Measured, configuration: Vector) -> Vector:
    """The centres (n, 2, 3) m of both soles."""
    heel, toe, _, height = person.sole_rectangle()
    poses = poses_of(tree_of(person), configuration)
    centre = np.array([(heel + toe) / 2, 0.0, height])
    return np.stack([poses.points(f"{side}_foot", centre) for side in SIDES], axis=1)


def planted(soles: Vector) -> Flags:
    """Whether each foot (n, 2) is on the ground: not higher than the lower one usually is, by `RAISED_M`."""
    return np.asarray(soles[:, :, 2] < np.median(soles[:, :, 2].min(axis=1)) + RAISED_M)


def sole_wrenches(model: pin.Model, motion: Movement, ground: Sequence[GroundForce], torques: Torques) -> Vector:
    """What the ground does to the soles (n, 12): force and moment at each centre, in its axes, as in `Motion`."""
    data = model.createData()
    frames = [model.getFrameId(f"{side}_sole") for side in SIDES]
    found = np.zeros((len(motion.configuration), 2 * WRENCH))
    for n, configuration in enumerate(motion.configuration):
        pin.framesForwardKinematics(model, data, configuration)
        soles = [data.oMf[frame] for frame in frames]
        wrenches = [pin.Force.Zero(), pin.Force.Zero()]
        if not ground:
            needed = pin.rnea(model, data, configuration, motion.velocity[n], motion.acceleration[n])[:WRENCH]
            wrenches = dynamics.shared_by_soles(
                data.oMi[1].act(pin.Force(needed)), np.array([s.translation for s in soles])
            )
        for plate, foot in zip(ground, torques.foot[n], strict=True):
            if foot >= 0:
                wrenches[foot] += pin.Force(plate.force_n[n], plate.moment_nm[n])
        found[n] = np.concatenate([sole.actInv(wrench).vector for sole, wrench in zip(soles, wrenches, strict=True)])
    return found


def later(ground: Sequence[GroundForce], rate_hz: float, lag_s: float) -> tuple[GroundForce, ...]:
    """Plates without a lag: what they show `lag_s` later."""
    if lag_s == 0:
        return tuple(ground)

    def moved(values: Vector) -> Vector:
        times = np.arange(len(values)) / rate_hz
        return np.column_stack([np.interp(times + lag_s, times, column) for column in values.T])

    return tuple(replace(plate, force_n=moved(plate.force_n), moment_nm=moved(plate.moment_nm)) for plate in ground)


def lag_s(shown_n: Vector, needed_n: Vector, rate_hz: float) -> float | None:
    """How much later the plates show the vertical force (n,) that the motion needs; None if they are not alike."""
    most = int(LONGEST_LAG_S * rate_hz)
    if min(needed_n.std(), shown_n.std()) < LEAST_CHANGE_N or len(needed_n) < 4 * most:
        return None
    inner = slice(most, len(needed_n) - most)
    likeness = np.array(
        [
            np.corrcoef(shown_n[inner.start + shift : inner.stop + shift], needed_n[inner])[0, 1]
            for shift in range(-most, most + 1)
        ]
    )
    best = int(likeness.argmax())
    if not 0 < best < 2 * most or likeness[best] < ALIKE:
        return None
    before, at, after = likeness[best - 1 : best + 2]
    return float((best - most + 0.5 * (before - after) / (before - 2 * at + after)) / rate_hz)


def unmeasured_contacts(model: pin.Model, motion: Movement, torques: Torques) -> list[Contact]:
    """What carries the person beside the plates; none if nothing was measured.

    Torques of the legs, the back and all that it loads are not to be believed meanwhile.
    """
    weight = pin.computeTotalMass(model) * GRAVITY_MPS2
    size = np.nan_to_num(np.linalg.norm(torques.residual_force_n, axis=1)) / weight
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (size > CONTACT_SHARE / 2).astype(int), [0]])))
    found = []
    for start, stop in edges.reshape(-1, 2).tolist():
        own = slice(start, stop)
        if longest_run(size[own] > CONTACT_SHARE) >= CONTACT_S * motion.rate_hz:
            force, moment = torques.residual_force_n[own], torques.residual_moment_nm[own]
            body = _nearest(model, motion.configuration[own], force, moment)
            found.append(Contact(start, stop, force.mean(axis=0), body))
    return found


def carried(found: Sequence[Contact], frames: int) -> Flags:
    """The frames (n,) in which something unmeasured carries."""
    flags = np.zeros(frames, dtype=bool)
    for contact in found:
        flags[contact.start : contact.stop] = True
    return flags


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


def on_one_plate(ground: Sequence[GroundForce], on_ground: Flags) -> Flags:
    """The frames (n,) in which both feet are on the ground and one plate alone is loaded."""
    loaded = np.array([plate.force_n[:, 2] > LEAST_N for plate in ground])
    return np.asarray((loaded.sum(axis=0) == 1) & on_ground.all(axis=1))


def plate_remarks(ground: Sequence[GroundForce], torques: Torques, on_ground: Flags) -> list[Remark]:
    """Which foot is on which plate, where that is not plain (fault 12)."""
    remarks = []
    for number, (plate, foot) in enumerate(zip(ground, torques.foot.T, strict=True), 1):
        loaded = plate.force_n[:, 2] > LEAST_N
        if not loaded.any():
            continue
        feet = foot[loaded]
        if (nowhere := float((feet < 0).mean())) >= TOLD_SHARE:
            remarks.append(
                Remark(12, f"plate {number} is pressed where no foot is, {percent(nowhere, 0)} of the time; left out.")
            )
        if min((feet == 0).mean(), (feet == 1).mean()) >= TOLD_SHARE:
            right = percent(float((feet == 0).sum() / (feet >= 0).sum()), 0)
            remarks.append(
                Remark(12, f"plate {number} carries one foot, then the other (the right one {right} of the time).")
            )
    if (both := float(on_one_plate(ground, on_ground).mean())) >= TOLD_SHARE:
        remarks.append(
            Remark(12, f"both feet are on one plate {percent(both, 0)} of the time; it counts for the nearer one.")
        )
    return remarks

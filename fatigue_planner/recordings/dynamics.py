"""From postures to torques: one smoother for motion and plates, inverse dynamics, and what is left of the wrench."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.human.multibody import BASE_DOF, GRAVITY_MPS2
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.recordings.kinematics.measured import Measured
from fatigue_planner.recordings.kinematics.tracking import SKIN_HZ
from fatigue_planner.recordings.recording import GroundForce

Vector = NDArray[np.float64]

# Zero-lag Butterworth filter of 4th order, forwards and backwards; for plates, too.
ORDER = 2
# A plate belongs to the foot in whose reach its centre of pressure is; it takes less for nothing.
LEAST_N, REACH_M = 20.0, 0.25
# Where nobody measured: the moment's lever in a sole, and how much higher a foot in the air is (assumed).
LEVER_M, RAISED_M = 0.05, 0.03
# Plates that carry somebody in a static trial show his weight to within this share (assumed).
CARRIED_SHARE, STEP_M = 0.05, 0.01


@dataclass(frozen=True)
class Movement:
    """A smooth motion: configurations (n, 46), velocities and accelerations (n, 45), as Pinocchio has them."""

    rate_hz: float
    configuration: Vector
    velocity: Vector
    acceleration: Vector


@dataclass(frozen=True)
class Torques:
    """Inverse dynamics: torques (n, 39) N.m, those of joints that no marker shows (`unmarked_joints`) assumed ones.

    And the force (n, 3) N and moment about the mid-hip (n, 3) N.m, in the world's axes, that no plate explains; foot
    (n, p): which foot stands on each plate: 0 right, 1 left, -1 neither.
    """

    torque_nm: Vector
    residual_force_n: Vector
    residual_moment_nm: Vector
    foot: NDArray[np.int64]


def smooth(values: Vector, rate_hz: float, cutoff_hz: float | None = SKIN_HZ) -> Vector:
    """Values (n, ...) without what is faster than the cut-off, if any. Raises RecordingError if there are too few."""
    if cutoff_hz is None:
        return values
    if rate_hz <= 2 * cutoff_hz:
        raise RecordingError(
            f"{rate_hz:g} frames a second are too few for torques, which need more than {2 * cutoff_hz:g}."
        )
    filters = butter(ORDER, cutoff_hz, fs=rate_hz, output="sos")
    pad = int(rate_hz / cutoff_hz * 2)
    if len(values) <= pad:
        raise RecordingError(f"{len(values)} frames are too few for torques; at least {pad + 1} are needed.")
    return np.asarray(sosfiltfilt(filters, values, axis=0, padlen=pad))


def movement(model: pin.Model, configuration: Vector, rate_hz: float, cutoff_hz: float | None = SKIN_HZ) -> Movement:
    """The motion through configurations (n, 46), and its derivatives, by central differences; all of them smooth."""
    middle = configuration[0]
    tangent = np.array([pin.difference(model, middle, one) for one in configuration])
    tangent[:, 3:6] = np.unwrap(tangent[:, 3:6], axis=0)
    own = np.array([pin.integrate(model, middle, one) for one in smooth(tangent, rate_hz, cutoff_hz)])
    forward = np.array([pin.difference(model, a, b) for a, b in pairwise(own)]) * rate_hz
    velocity = np.concatenate([forward[:1], (forward[:-1] + forward[1:]) / 2, forward[-1:]])
    change = np.diff(forward, axis=0) * rate_hz
    acceleration = np.concatenate([change[:1], change, change[-1:]])
    return Movement(rate_hz, own, smooth(velocity, rate_hz, cutoff_hz), smooth(acceleration, rate_hz, cutoff_hz))


def ground_at(
    ground: Sequence[GroundForce], ground_rate_hz: float, frames: int, rate_hz: float, cutoff_hz: float | None = SKIN_HZ
) -> list[GroundForce]:
    """The plates, smoothed like the motion, at its frames."""
    times = np.arange(frames) / rate_hz
    found = []
    for plate in ground:
        both = smooth(
            np.nan_to_num(np.concatenate([plate.force_n, plate.moment_nm], axis=1)), ground_rate_hz, cutoff_hz
        )
        own = np.arange(len(both)) / ground_rate_hz
        at = np.column_stack([np.interp(times, own, column) for column in both.T])
        found.append(GroundForce(at[:, :3], at[:, 3:], plate.corners_m))
    return found


def inverse_dynamics(model: pin.Model, motion: Movement, ground: Sequence[GroundForce]) -> Torques:
    """The torques that make the motion under what the plates do to the feet (at the motion's frames).

    Without plates the ground does to the soles what the motion needs (`shared_by_soles`); nothing is left then, and the
    residuals are NaN, as nobody measured them. The joints above the pelvis do not depend on it.
    """
    data = model.createData()
    soles = [model.frames[model.getFrameId(f"{side}_sole")] for side in SIDES]
    frames = len(motion.configuration)
    torque, residual = np.empty((frames, model.nv - BASE_DOF)), np.empty((frames, BASE_DOF))
    foot = np.full((frames, len(ground)), -1)
    centres = [plate.centre_m(LEAST_N) for plate in ground]
    for n in range(frames):
        configuration = motion.configuration[n]
        pin.framesForwardKinematics(model, data, configuration)
        places = np.array([data.oMf[model.getFrameId(f"{side}_sole")].translation[:2] for side in SIDES])
        outside = pin.StdVec_Force([pin.Force.Zero() for _ in range(model.njoints)])
        for p, plate in enumerate(ground):
            away = np.linalg.norm(places - centres[p][n], axis=1)
            if not np.isfinite(away).all():
                continue
            side = int(away.argmin())
            foot[n, p] = side if away[side] < REACH_M else -1
            joint = soles[side].parentJoint
            outside[joint] += data.oMi[joint].actInv(pin.Force(plate.force_n[n], plate.moment_nm[n]))
        state = (configuration, motion.velocity[n], motion.acceleration[n])
        if not ground:
            needed = data.oMi[1].act(pin.Force(pin.rnea(model, data, *state)[:BASE_DOF]))
            at = np.array([data.oMf[model.getFrameId(f"{side}_sole")].translation for side in SIDES])
            for sole, wrench in zip(soles, shared_by_soles(needed, at), strict=True):
                outside[sole.parentJoint] += data.oMi[sole.parentJoint].actInv(wrench)
        found = pin.rnea(model, data, *state, outside)
        torque[n] = found[BASE_DOF:]
        turn = data.oMi[1].rotation
        residual[n, :3], residual[n, 3:] = turn @ found[:3], turn @ found[3:6]
    residual = residual if ground else np.full_like(residual, np.nan)
    return Torques(torque, residual[:, :3], residual[:, 3:], foot)


def balanced(person: Measured, motion: Movement, ground: Sequence[GroundForce]) -> Measured:
    """The person with the masses above the pelvis as far forward as plates say in a static trial (at its frames).

    As residual reduction (OpenSim's RRA) moves the torso's centre of mass, but from somebody who stands still, so that
    no motion is fitted to what it is to be judged by. Raises RecordingError if the plates do not carry him.
    """
    weight = person.mass_kg * GRAVITY_MPS2
    carried = float(np.mean(np.sum([plate.force_n[:, 2] for plate in ground], axis=0)))
    if not abs(carried / weight - 1) < CARRIED_SHARE:
        raise RecordingError(
            f"the plates carry {carried:.0f} N in the static trial, not the person's {weight:.0f} N; it says nothing "
            "of where his mass is."
        )

    def pitch_nm(forward_m: float) -> float:
        model = replace(person, trunk_forward_m=forward_m).model()
        return float(inverse_dynamics(model, motion, ground).residual_moment_nm[:, 1].mean())

    at, before = pitch_nm(0.0), pitch_nm(STEP_M)
    return replace(person, trunk_forward_m=STEP_M * at / (at - before))


def shared_by_soles(needed: pin.Force, soles_m: Vector) -> list[pin.Force]:
    """A wrench about the world's origin, shared by the soles (2, 3) m: that of the smallest forces and moments.

    Moments count as forces at a lever of `LEVER_M`; a sole higher than the other by `RAISED_M` carries nothing.
    """
    low = soles_m[:, 2] <= soles_m[:, 2].min() + RAISED_M
    arms = np.zeros((6, 12))
    weight = np.empty(12)
    for side, place in enumerate(soles_m):
        own = slice(6 * side, 6 * side + 6)
        arms[:, own] = np.eye(6)
        arms[3:, 6 * side : 6 * side + 3] = pin.skew(place)
        weight[own] = np.repeat([1.0, LEVER_M**2], 3) * (1.0 if low[side] else 0.0)
    spread = weight[:, None] * arms.T
    found = spread @ np.linalg.solve(arms @ spread, needed.vector)
    return [
        pin.Force(found[6 * side :][:3], found[6 * side + 3 :][:3] + np.cross(place, found[6 * side :][:3]))
        for side, place in enumerate(soles_m)
    ]

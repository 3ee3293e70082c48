"""Quantities of a stored motion, recomputed by Pinocchio algorithms the controller does not use."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.model import Human
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.motion import Motion

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

_LOCAL, _WORLD = pin.ReferenceFrame.LOCAL, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


@dataclass(frozen=True)
class Replay:
    """A run of n ticks with the same body.

    residual_nm (n, 45): M a + h - S' (tau + tau_tissue) - J' w - J_h' f_h; centre_of_mass_m (n, 3); energy_j (n,):
    kinetic and potential; actuator_work_j and contact_work_j (n - 1,): what the joint torques, of muscles and tissue,
    and the ground and the forces on the hands, do between a tick and the next, at the mean of both velocities;
    hand_poses (n, 2) the poses of the right and left hand's frame; sole_displacement_m (n, 2) how far the corner of a
    sole that moved most is from where it stood in the natural stance.
    """

    residual_nm: Matrix
    centre_of_mass_m: Matrix
    energy_j: Vector
    actuator_work_j: Vector
    contact_work_j: Vector
    hand_poses: list[tuple[pin.SE3, pin.SE3]]
    sole_displacement_m: Matrix


def replay(human: Human, motion: Motion, ticks: range) -> Replay:
    """Recompute the ticks of a run."""
    model, data = human.model, human.model.createData()
    soles, hands = ([model.getFrameId(f"{side}_{part}") for side in SIDES] for part in ("sole", "grip"))
    pin.framesForwardKinematics(model, data, human.stance)
    length, breadth = human.sole_half_length_m, human.sole_half_breadth_m
    corners = np.array([[x, y, 0] for x in (-length, length) for y in (-breadth, breadth)])
    home = [_points(data.oMf[sole], corners) for sole in soles]
    displacement = np.empty((len(ticks), 2))
    residual, centre = np.empty((len(ticks), model.nv)), np.empty((len(ticks), 3))
    energy, contact_work = np.empty(len(ticks)), np.empty(len(ticks) - 1)
    hand_poses = []
    pushed_hands = bool(motion.hand_force_n.any())
    torque = motion.torque_nm + motion.tissue_nm
    velocity = motion.velocity[ticks.start : ticks.stop]
    mean_velocity = (velocity[1:] + velocity[:-1]) / 2
    for row, tick in enumerate(ticks):
        q, v = motion.configuration[tick], motion.velocity[tick]
        residual[row] = pin.rnea(model, data, q, v, motion.acceleration[tick])
        centre[row] = pin.centerOfMass(model, data, q)
        energy[row] = pin.computeKineticEnergy(model, data, q, v) + pin.computePotentialEnergy(model, data, q)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        residual[row, BASE_DOF:] -= torque[tick]
        pushed = np.zeros(model.nv)
        for sole, wrench in zip(soles, motion.wrench[tick].reshape(2, 6), strict=True):
            pushed += wrench @ pin.getFrameJacobian(model, data, sole, _LOCAL)
        if pushed_hands:
            for hand, force in zip(hands, motion.hand_force_n[tick].reshape(2, 3), strict=True):
                pushed += force @ pin.getFrameJacobian(model, data, hand, _WORLD)[:3]
        residual[row] -= pushed
        hand_poses.append((data.oMf[hands[0]].copy(), data.oMf[hands[1]].copy()))
        displacement[row] = [
            np.linalg.norm(_points(data.oMf[sole], corners) - at, axis=1).max()
            for sole, at in zip(soles, home, strict=True)
        ]
        if row < len(contact_work):
            contact_work[row] = motion.time_step_s * (pushed @ mean_velocity[row])
    acting = torque[ticks.start : ticks.stop - 1]
    work = motion.time_step_s * np.einsum("ij,ij->i", acting, mean_velocity[:, BASE_DOF:])
    return Replay(residual, centre, energy, work, contact_work, hand_poses, displacement)


def _points(placement: pin.SE3, local: Matrix) -> Matrix:
    """Points (k, 3) of a frame in the world."""
    return np.asarray(local @ placement.rotation.T + placement.translation)


def energy_error_share(runs: list[Replay]) -> float:
    """Power balance: |energy change - actuator work - contact work| over the work done, at its worst.

    The error accumulates over a run; the largest of each run are added up and divided by the sum of the
    absolute work, so that it is a share of what went through the body. It vanishes with the time step
    (first order).
    """
    errors, turnover = [], 0.0
    for run in runs:
        work = run.actuator_work_j + run.contact_work_j
        errors.append(np.abs(run.energy_j[1:] - run.energy_j[0] - np.cumsum(work)).max())
        turnover += np.abs(run.actuator_work_j).sum() + np.abs(run.contact_work_j).sum()
    return 0.0 if turnover == 0 else float(np.sum(errors) / turnover)

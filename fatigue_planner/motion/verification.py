"""Independent checks of a simulated motion, from what is stored of it."""

from dataclasses import asdict, dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.joint_data import maximum_torques
from fatigue_planner.human.model import BASE_DOF, Human, build_human
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.motion.simulator import Motion, MotionRequest

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Quality:
    """The worst value over all ticks of everything a motion has to fulfil (SI; <= 0 means kept)."""

    equation_of_motion_nm: float
    friction_violation_n: float
    unilateral_violation_n: float
    centre_of_pressure_violation_m: float
    torque_violation_nm: float
    position_violation_rad: float
    velocity_violation_radps: float
    foot_displacement_m: float
    work_hand_error_m: float

    def faults(self, required: Accuracy) -> list[str]:
        """What is not fulfilled, in words; empty for a motion that can be used."""
        faults = []
        if self.work_hand_error_m > required.hand_error_m:
            faults.append(
                f"the hand stays {self.work_hand_error_m * 100:.1f} cm from its target during work (allowed: "
                f"{required.hand_error_m * 100:.1f} cm): out of reach for this worker and preference; bring the "
                "object closer"
            )
        bounds = {
            "equation_of_motion_nm": required.equation_of_motion_nm,
            "foot_displacement_m": required.foot_displacement_m,
        }
        for name, value in asdict(self).items():
            allowed = bounds.get(name, required.limit_violation)
            if name != "work_hand_error_m" and not value <= allowed:
                faults.append(f"{name} = {value:.2e} (allowed: {allowed:.0e})")
        return faults


def measure(request: MotionRequest, motion: Motion) -> Quality:
    """Recompute every check from the stored arrays with Pinocchio's own algorithms.

    The equation of motion is evaluated by the recursive Newton-Euler algorithm, which the controller
    does not use. NaN anywhere makes the checks it touches NaN, which no bound accepts.
    """
    with_tool = build_human(request.worker, request.tool.mass_kg)
    bodies = dict.fromkeys(("reach", "work", "return"), with_tool)
    if request.tool.held == "work":
        bodies["reach"] = bodies["return"] = build_human(request.worker)
    residual = np.concatenate(
        [_residuals(bodies[phase.name], motion, range(phase.start, phase.stop)) for phase in motion.phases]
    )
    positive, negative = (
        request.controller.torque_limit_factor * torque for torque in maximum_torques(request.worker.strength)
    )
    joints, speeds = motion.configuration[:, 7:], motion.velocity[:, BASE_DOF:]
    model = with_tool.model
    forces = motion.wrench.reshape(-1, 6)
    tangential = np.hypot(forces[:, 0], forces[:, 1])
    normal = forces[:, 2]
    pressing = np.maximum(normal, 1e-9)
    off_centre = np.maximum(
        np.abs(forces[:, 4]) / pressing - with_tool.sole_half_length_m,
        np.abs(forces[:, 3]) / pressing - with_tool.sole_half_breadth_m,
    )
    return Quality(
        equation_of_motion_nm=float(np.abs(residual).max()),
        friction_violation_n=float((tangential - request.controller.friction_coefficient * normal).max()),
        unilateral_violation_n=float((-normal).max()),
        centre_of_pressure_violation_m=float(off_centre.max()),
        torque_violation_nm=float(np.maximum(motion.torque_nm - positive, -motion.torque_nm - negative).max()),
        position_violation_rad=float(
            np.maximum(joints - model.upperPositionLimit[7:], model.lowerPositionLimit[7:] - joints).max()
        ),
        velocity_violation_radps=float((np.abs(speeds) - request.controller.velocity_limit_radps).max()),
        foot_displacement_m=float(motion.foot_displacement_m.max()),
        work_hand_error_m=float(motion.hand_error_m[motion.phase("work")].max()),
    )


def _residuals(human: Human, motion: Motion, ticks: range) -> Vector:
    """M a + h - S' tau - J' w per tick, (len(ticks), 45)."""
    model, data = human.model, human.model.createData()
    soles = [model.getFrameId(f"{side}_sole") for side in ("right", "left")]
    residual = np.empty((len(ticks), model.nv))
    for row, tick in enumerate(ticks):
        q, v, a = motion.configuration[tick], motion.velocity[tick], motion.acceleration[tick]
        residual[row] = pin.rnea(model, data, q, v, a)
        residual[row, BASE_DOF:] -= motion.torque_nm[tick]
        for sole, wrench in zip(soles, motion.wrench[tick].reshape(2, 6), strict=True):
            jacobian = pin.computeFrameJacobian(model, data, q, sole, pin.ReferenceFrame.LOCAL)
            residual[row] -= jacobian.T @ wrench
    return residual

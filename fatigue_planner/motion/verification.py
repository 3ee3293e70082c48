"""Independent checks of a simulated motion, from what is stored of it."""

from dataclasses import asdict, dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from fatigue_planner.human.joint_data import maximum_torques
from fatigue_planner.human.model import BASE_DOF, Human, build_human
from fatigue_planner.motion.contact import WRENCH, wrench_cone
from fatigue_planner.motion.motion import Motion, Phase
from fatigue_planner.motion.replay import energy_error_share, replay
from fatigue_planner.motion.settings import Accuracy
from fatigue_planner.motion.simulator import PHASES, MotionRequest, target_pose

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Quality:
    """The worst value over all ticks of everything a motion has to fulfil (SI; <= 0 means kept)."""

    equation_of_motion_nm: float
    friction_violation_n: float
    unilateral_violation_n: float
    centre_of_pressure_violation_m: float
    wrench_cone_violation: float
    torque_violation_nm: float
    position_violation_rad: float
    velocity_violation_radps: float
    centre_of_mass_violation_m: float
    energy_error_share: float
    foot_displacement_m: float
    work_hand_error_m: float

    def faults(self, required: Accuracy) -> list[str]:
        """What is not fulfilled, in words; empty for a motion that can be used."""
        faults = []
        if not self.work_hand_error_m <= required.hand_error_m:
            faults.append(
                f"the hand stays {self.work_hand_error_m * 100:.1f} cm from its target during work (allowed: "
                f"{required.hand_error_m * 100:.1f} cm): out of reach for this worker and preference; bring the "
                "object closer"
            )
        bounds = {
            "equation_of_motion_nm": required.equation_of_motion_nm,
            "foot_displacement_m": required.foot_displacement_m,
            "energy_error_share": required.energy_error_share,
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
    bodies = dict.fromkeys(PHASES, with_tool)
    if request.tool.held == "work":
        bodies["reach"] = bodies["return"] = build_human(request.worker)
    # where the tool is taken up or put down, the mass changes and a new run begins
    runs = motion.phases if request.tool.held == "work" else (Phase("cycle", 0, motion.phases[-1].stop),)
    replays = [replay(bodies.get(run.name, with_tool), motion, run) for run in runs]
    factor = request.controller.torque_limit_factor
    positive, negative = (factor * torque for torque in maximum_torques(request.worker.strength))
    joints, speeds = motion.configuration[:, 7:], motion.velocity[:, BASE_DOF:]
    model = with_tool.model
    forces = motion.wrench.reshape(-1, WRENCH)
    friction, length, breadth = (
        request.controller.friction_coefficient, with_tool.sole_half_length_m, with_tool.sole_half_breadth_m
    )  # fmt: skip
    normal = forces[:, 2]
    pressing = np.maximum(normal, 1e-9)
    off_centre = np.maximum(np.abs(forces[:, 4]) / pressing - length, np.abs(forces[:, 3]) / pressing - breadth)
    fist = np.concatenate([run.fist_m for run in replays])[motion.phase("work")]
    return Quality(
        equation_of_motion_nm=float(max(np.abs(run.residual_nm).max() for run in replays)),
        friction_violation_n=float((np.hypot(forces[:, 0], forces[:, 1]) - friction * normal).max()),
        unilateral_violation_n=float((-normal).max()),
        centre_of_pressure_violation_m=float(off_centre.max()),
        wrench_cone_violation=float((forces @ wrench_cone(length, breadth, friction).T).max()),
        torque_violation_nm=float(np.maximum(motion.torque_nm - positive, -motion.torque_nm - negative).max()),
        position_violation_rad=float(
            np.maximum(joints - model.upperPositionLimit[7:], model.lowerPositionLimit[7:] - joints).max()
        ),
        velocity_violation_radps=float((np.abs(speeds) - request.controller.velocity_limit_radps).max()),
        centre_of_mass_violation_m=max(_outside_support(with_tool, run.centre_of_mass_m) for run in replays),
        energy_error_share=max(energy_error_share(run) for run in replays),
        foot_displacement_m=float(max(run.sole_displacement_m.max() for run in replays)),
        work_hand_error_m=float(np.linalg.norm(fist - target_pose(request.action).position_m, axis=1).max()),
    )


def _outside_support(human: Human, centre_of_mass_m: Matrix) -> float:
    """How far the centre of mass leaves the convex hull of both soles, seen from above; <= 0 inside."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, human.stance)
    length, breadth = human.sole_half_length_m, human.sole_half_breadth_m
    corners = [
        data.oMf[human.model.getFrameId(f"{side}_sole")].act(np.array([x, y, 0]))[:2]
        for side in ("right", "left")
        for x in (-length, length)
        for y in (-breadth, breadth)
    ]
    planes = ConvexHull(corners).equations
    return float((centre_of_mass_m[:, :2] @ planes[:, :2].T + planes[:, 2]).max())

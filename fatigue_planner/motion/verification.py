"""Independent checks of a simulated motion, from what is stored of it."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from fatigue_planner.human.model import BASE_DOF, Human, build_human
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.contact import WRENCH, wrench_cone
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.quality import Quality
from fatigue_planner.motion.references import hand_reference
from fatigue_planner.motion.replay import energy_error_share, replay
from fatigue_planner.motion.saturation import saturation
from fatigue_planner.motion.schedule import forces_of, phases_of, runs_of
from fatigue_planner.motion.simulator import MotionRequest

Matrix = NDArray[np.float64]


# A sole that presses less has no centre of pressure to speak of; its moments still have to be as small.
PRESSING_N = 1.0


@dataclass(frozen=True)
class _HandErrors:
    """The largest distance (m) and turn (rad) of a fist from its reference during work."""

    distance_m: float
    turn_rad: float


def measure(request: MotionRequest, motion: Motion) -> Quality:
    """Recompute every check from the stored arrays with Pinocchio's own algorithms.

    The equation of motion is evaluated by the recursive Newton-Euler algorithm, which the controller
    does not use. NaN anywhere makes the checks it touches NaN, which no bound accepts.
    """
    runs = runs_of(request.tool, request.action, phases_of(request.cycle, motion.time_step_s))
    bodies = [build_human(request.worker, run.right_kg, run.left_kg) for run in runs]
    # where a mass is taken up or put down, the body changes and a new run begins
    replays = [replay(body, motion, range(run.start, run.stop)) for body, run in zip(bodies, runs, strict=True)]
    human = bodies[0]
    factor = request.controller.torque_limit_factor
    positive, negative = (factor * torque for torque in request.maximum_torque.vectors())
    joints, speeds = motion.configuration[:, 7:], motion.velocity[:, BASE_DOF:]
    model = human.model
    forces = motion.wrench.reshape(-1, WRENCH)
    friction, length, breadth = (
        request.controller.friction_coefficient, human.sole_half_length_m, human.sole_half_breadth_m
    )  # fmt: skip
    normal = forces[:, 2]
    pressing = np.maximum(normal, PRESSING_N)
    tipping = np.abs(forces[:, [4, 3]]) - normal[:, None] * [length, breadth]
    off_centre = (tipping / pressing[:, None]).max(axis=1)
    hands = _hand_errors(request, motion, [fists for run in replays for fists in run.fists])
    saturated = saturation(motion.torque_nm[motion.phase("work")], positive, negative)
    eased = np.abs(motion.eased_radps2).max(axis=1)
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
        centre_of_mass_violation_m=max(_outside_support(human, run.centre_of_mass_m) for run in replays),
        energy_error_share=max(energy_error_share(run) for run in replays),
        foot_displacement_m=float(max(run.sole_displacement_m.max() for run in replays)),
        hand_force_error_n=_force_error(request, motion, [fists for run in replays for fists in run.fists]),
        work_hand_error_m=hands.distance_m,
        work_hand_turn_rad=hands.turn_rad,
        saturated_share=saturated.share,
        saturated_joint=saturated.joint,
        eased_ticks=int((eased > 0).sum()),
        eased_radps2=float(eased.max()),
    )


def _hand_errors(request: MotionRequest, motion: Motion, fists: list[tuple[pin.SE3, pin.SE3]]) -> _HandErrors:
    human = build_human(request.worker)
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, human.stance)
    distance = turn = 0.0
    work = motion.phase("work")
    for side, goal in request.action.goals().items():
        grip = data.oMf[human.model.getFrameId(f"{side}_grip")]
        wanted = hand_reference(Pose(grip.translation, grip.rotation), goal, motion.phases, motion.time_step_s)
        for tick in range(work.start, work.stop):
            fist = fists[tick][SIDES.index(side)]
            # a NaN must win: max() would lose it
            distance = np.maximum(distance, np.linalg.norm(fist.translation - wanted.position_m[tick]))
            if goal.turned():
                turn = np.maximum(turn, np.linalg.norm(pin.log3(wanted.rotation[tick] @ fist.rotation.T)))
    return _HandErrors(float(distance), float(turn))


def _force_error(request: MotionRequest, motion: Motion, fists: list[tuple[pin.SE3, pin.SE3]]) -> float:
    """How far the stored forces on the hands are from those the action prescribes."""
    prescribed = np.zeros_like(motion.hand_force_n)
    for planned in forces_of(request.action, len(prescribed), motion.time_step_s):
        place = SIDES.index(planned.hand)
        for tick, force in enumerate(planned.force_n):
            turned = fists[tick][place].rotation @ force if planned.in_hand_axes else force
            prescribed[tick, 3 * place : 3 * place + 3] += turned
    return float(np.abs(motion.hand_force_n - prescribed).max())


def _outside_support(human: Human, centre_of_mass_m: Matrix) -> float:
    """How far the centre of mass leaves the convex hull of both soles, seen from above; <= 0 inside."""
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, human.stance)
    length, breadth = human.sole_half_length_m, human.sole_half_breadth_m
    corners = [
        data.oMf[human.model.getFrameId(f"{side}_sole")].act(np.array([x, y, 0]))[:2]
        for side in SIDES
        for x in (-length, length)
        for y in (-breadth, breadth)
    ]
    planes = ConvexHull(corners).equations
    return float((centre_of_mass_m[:, :2] @ planes[:, :2].T + planes[:, 2]).max())

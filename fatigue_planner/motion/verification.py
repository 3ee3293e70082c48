"""Independent checks of a simulated motion, from what is stored of it."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.model import Human
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.contact import WRENCH, wrench_cone
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.motion.motion import ROWS, Motion
from fatigue_planner.motion.physiology.registry import tissue_of
from fatigue_planner.motion.plausibility import measure_plausibility
from fatigue_planner.motion.quality import Quality, saturation
from fatigue_planner.motion.replay import energy_error_share, replay
from fatigue_planner.motion.schedule import forces_of, hand_reference, phases_of, runs_of

Matrix = NDArray[np.float64]

# A sole that presses less has no meaningful centre of pressure; its moments still have to be as small.
PRESSING_N = 1.0


class MismatchError(ValueError):
    """A motion is not of the shape its settings describe."""


@dataclass(frozen=True)
class _HandErrors:
    """The largest distance (m) and turn (rad) of a hand from its reference during work; and how far the
    distances recorded over the whole cycle are from these.
    """

    distance_m: float
    turn_rad: float
    recorded_m: float


def measure(request: MotionRequest, motion: Motion) -> Quality:
    """Recompute every check from the stored arrays with Pinocchio's own algorithms.

    The equation of motion is evaluated by the recursive Newton-Euler algorithm, which the controller
    does not use. Values that are not finite are counted, and a check that they enter passes no bound.
    Raises MismatchError if the motion has another shape than the request asks for.
    """
    check_shape(request, motion)
    runs = runs_of(request.tool, request.action, motion.phases)
    bodies = [run.human(request.worker) for run in runs]
    # where a mass is taken up or put down, the body changes and a new run begins
    replays = [replay(body, motion, range(run.start, run.stop)) for body, run in zip(bodies, runs, strict=True)]
    hand_poses = [both for run in replays for both in run.hand_poses]
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
    hands = _hand_errors(human, request, motion, hand_poses)
    at_work = motion.torque_nm[motion.phase("work")]
    saturated = saturation(at_work, positive, negative)
    mean_share = np.maximum(at_work / positive, -at_work / negative).mean(axis=0) * factor
    eased = np.abs(motion.eased_radps2).max(axis=1)
    # np.max, not max: a NaN must win
    return Quality(
        not_finite=int(sum((~np.isfinite(getattr(motion, name))).sum() for name in ROWS)),
        record_error=float(
            np.max([_integration_error(human, motion), _force_error(request, motion, hand_poses), hands.recorded_m])
        ),
        equation_of_motion_nm=float(np.max([np.abs(run.residual_nm).max() for run in replays])),
        friction_violation_n=float((np.hypot(forces[:, 0], forces[:, 1]) - friction * normal).max()),
        unilateral_violation_n=float((-normal).max()),
        centre_of_pressure_violation_m=float((tipping / pressing[:, None]).max()),
        wrench_cone_violation=float((forces @ wrench_cone(length, breadth, friction).T).max()),
        torque_violation_nm=float(np.maximum(motion.torque_nm - positive, -motion.torque_nm - negative).max()),
        tissue_violation_nm=_tissue_violation(request, human, motion),
        position_violation_rad=float(
            np.maximum(joints - model.upperPositionLimit[7:], model.lowerPositionLimit[7:] - joints).max()
        ),
        velocity_violation_radps=float((np.abs(speeds) - request.controller.velocity_limit_radps).max()),
        centre_of_mass_violation_m=float(np.max([_outside_support(human, run.centre_of_mass_m) for run in replays])),
        energy_error_share=energy_error_share(replays),
        foot_displacement_m=float(np.max([run.sole_displacement_m.max() for run in replays])),
        work_hand_error_m=hands.distance_m,
        work_hand_turn_rad=hands.turn_rad,
        largest_load_share=float(mean_share.max()),
        largest_load_joint=DEGREES_OF_FREEDOM[int(mean_share.argmax())],
        saturated_share=saturated.share,
        saturated_joint=saturated.joint,
        eased_ticks=int((eased > 0).sum()),
        eased_radps2=float(eased.max()),
        plausibility=measure_plausibility(request, motion),
    )


def check_shape(request: MotionRequest, motion: Motion) -> None:
    """Raise MismatchError unless time step, phases and the lengths of all arrays are those of the request."""
    step = request.controller.time_step_s
    phases = phases_of(request.cycle, step)
    lengths = {len(getattr(motion, name)) for name in ROWS}
    if motion.time_step_s != step or motion.phases != phases or lengths != {phases[-1].stop}:
        raise MismatchError("the motion has another time step, other phases or another length than its settings say")


def _integration_error(human: Human, motion: Motion) -> float:
    """How far the motion is from starting at rest in the stance and following its own accelerations."""
    model, step = human.model, motion.time_step_s
    velocity = motion.velocity[:-1] + step * motion.acceleration[:-1]
    ahead = [pin.integrate(model, q, step * v) for q, v in zip(motion.configuration[:-1], velocity, strict=True)]
    parts = (
        motion.configuration[0] - human.stance,
        motion.velocity[0],
        motion.velocity[1:] - velocity,
        motion.configuration[1:] - np.array(ahead),
    )
    return float(np.max([np.abs(part).max() for part in parts]))


def _tissue_violation(request: MotionRequest, human: Human, motion: Motion) -> float:
    """How far the torques of tissue and stops are from what the human's tissue exerts and his stops may bear."""
    tissue = tissue_of(request.worker.human, human.anthropometry)
    if tissue is None:
        return float(np.abs(motion.tissue_nm).max())
    step = motion.time_step_s
    speeds = motion.velocity[:, BASE_DOF:] + step * motion.acceleration[:, BASE_DOF:]
    angles = motion.configuration[:, 7:] + step * speeds
    total = motion.torque_nm + motion.tissue_nm
    expected = np.array([tissue.borne(*tick) for tick in zip(angles, total, strict=True)])
    return float(np.abs(motion.tissue_nm - expected).max())


def _hand_errors(
    human: Human, request: MotionRequest, motion: Motion, hand_poses: list[tuple[pin.SE3, pin.SE3]]
) -> _HandErrors:
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, human.stance)
    distances, turn = [], 0.0
    work = motion.phase("work")
    for side, goal in request.action.goals().items():
        home = data.oMf[human.model.getFrameId(f"{side}_grip")]
        wanted = hand_reference(Pose(home.translation, home.rotation), goal, motion.phases, motion.time_step_s)
        own = [both[SIDES.index(side)] for both in hand_poses]
        distances.append(np.linalg.norm([pose.translation for pose in own] - wanted.position_m, axis=1))
        if goal.turned():
            turns = [
                np.linalg.norm(pin.log3(wanted.rotation[i] @ own[i].rotation.T)) for i in range(*work.indices(len(own)))
            ]
            turn = np.maximum(turn, np.max(turns))
    largest = np.max(distances, axis=0)
    recorded = float(np.abs(motion.hand_error_m - largest).max())
    return _HandErrors(float(largest[work].max()), float(turn), recorded)


def _force_error(request: MotionRequest, motion: Motion, hand_poses: list[tuple[pin.SE3, pin.SE3]]) -> float:
    """How far the stored forces on the hands are from those the action prescribes."""
    prescribed = np.zeros_like(motion.hand_force_n)
    for planned in forces_of(request.action, len(prescribed), motion.time_step_s):
        hand = SIDES.index(planned.hand)
        for tick, force in enumerate(planned.force_n):
            turned = hand_poses[tick][hand].rotation @ force if planned.in_hand_axes else force
            prescribed[tick, 3 * hand : 3 * hand + 3] += turned
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
    from scipy.spatial import ConvexHull  # noqa: PLC0415 - takes 0.2 s

    planes = ConvexHull(corners).equations
    return float((centre_of_mass_m[:, :2] @ planes[:, :2].T + planes[:, 2]).max())

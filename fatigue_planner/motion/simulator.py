"""One cycle of the digital human: reach, work, return."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.errors import FailedMotionError
from fatigue_planner.human.joint_data import maximum_torques
from fatigue_planner.human.model import Human, Tool, Worker, build_human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.controller import WholeBodyController
from fatigue_planner.motion.minimum_jerk import Pose, Reach
from fatigue_planner.motion.motion import Motion, Phase
from fatigue_planner.motion.settings import Action, Controller, Cycle, Preference
from fatigue_planner.motion.tasks import CentreOfMassTask, HandTask, PostureTask, SegmentUprightTask

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

PHASES = ("reach", "work", "return")


@dataclass(frozen=True)
class MotionRequest:
    """Everything that decides a motion."""

    worker: Worker
    tool: Tool
    cycle: Cycle
    controller: Controller
    action: Action
    preference: Preference


def target_pose(action: Action) -> Pose:
    """The pose the right fist has to take."""
    position, turn = action.position_m, action.orientation_deg
    rotation = pin.rpy.rpyToMatrix(np.radians([turn.x, turn.y, turn.z]))
    return Pose(np.array([position.x, position.y, position.z]), rotation)


def phases_of(cycle: Cycle, time_step_s: float) -> tuple[Phase, ...]:
    """The phases in ticks; their lengths are rounded to whole ticks."""
    ends = np.cumsum([cycle.reach_s, cycle.work_s, cycle.return_s])
    ticks = [0, *(round(end / time_step_s) for end in ends)]
    return tuple(Phase(name, ticks[i], ticks[i + 1]) for i, name in enumerate(PHASES))


class _Body:
    """The worker with or without the tool: state, tasks and controller."""

    def __init__(self, request: MotionRequest, tool_mass_kg: float) -> None:
        settings = request.controller
        weights, stiffness = settings.weights, settings.stiffness_per_s2
        self.human: Human = build_human(request.worker, tool_mass_kg)
        self.state = state = BodyState(self.human)
        state.update(self.human.stance, np.zeros(self.human.model.nv))
        self.hand = HandTask(weights.hand, stiffness.hand, state.frame("right_grip"))
        upright = [
            SegmentUprightTask(task.weight, stiffness.segment, state.frame(task.segment))
            for task in request.preference.tasks
        ]
        balance = CentreOfMassTask(weights.centre_of_mass, stiffness.centre_of_mass, state.data.com[0].copy())
        posture = PostureTask(weights.posture, stiffness.posture, self.human.stance[7:])
        strength = maximum_torques(request.worker.strength)
        self.controller = WholeBodyController(
            self.human, state, settings, strength, posture, [balance, self.hand, *upright]
        )

    def fist(self) -> Pose:
        """Where the right fist is."""
        placement = self.state.placement(self.hand.frame)
        return Pose(placement.translation.copy(), placement.rotation.copy())


def simulate(request: MotionRequest) -> Motion:
    """Simulate one cycle from the natural stance.

    The state is integrated on the configuration manifold by semi-implicit Euler steps. Raises
    FailedMotionError, naming phase and time, if the program has no solution at some tick.
    """
    dt = request.controller.time_step_s
    phases = phases_of(request.cycle, dt)
    ticks = phases[-1].stop
    loaded = _Body(request, request.tool.mass_kg)
    bodies = dict.fromkeys(PHASES, loaded)
    if request.tool.held == "work":
        bodies["reach"] = bodies["return"] = _Body(request, 0.0)
    home, target = loaded.fist(), target_pose(request.action)
    references = {
        "reach": Reach(home, target, request.cycle.reach_s),
        "work": Reach(target, target, request.cycle.work_s),
        "return": Reach(target, home, request.cycle.return_s),
    }
    model = loaded.human.model
    configuration, velocity = loaded.human.stance.copy(), np.zeros(model.nv)
    record = {
        name: np.empty((ticks, width))
        for name, width in {
            "configuration": model.nq, "velocity": model.nv, "acceleration": model.nv,
            "torque_nm": model.nv - 6, "wrench": 12, "foot_displacement_m": 2,
        }.items()
    }  # fmt: skip
    hand_error = np.empty(ticks)
    for phase in phases:
        body, reference = bodies[phase.name], references[phase.name]
        for tick in range(phase.start, phase.stop):
            body.state.update(configuration, velocity)
            body.hand.reference = reference.at((tick - phase.start) * dt)
            result = body.controller.step()
            if result is None:
                raise FailedMotionError(
                    f"no admissible movement at t = {tick * dt:.2f} s ({phase.name}): the limits of joints, torques "
                    "and foot contact contradict each other. Bring the object closer, make the tool lighter or the "
                    "phase longer."
                )
            acceleration, wrench, torque = result
            record["configuration"][tick], record["velocity"][tick] = configuration, velocity
            record["acceleration"][tick], record["torque_nm"][tick], record["wrench"][tick] = (
                acceleration,
                torque,
                wrench,
            )
            hand_error[tick] = np.linalg.norm(body.fist().position_m - body.hand.reference.pose.position_m)
            record["foot_displacement_m"][tick] = [
                np.linalg.norm(contact.displacement(body.state)[:3]) for contact in body.controller.contacts
            ]
            velocity = velocity + dt * acceleration
            configuration = pin.integrate(model, configuration, dt * velocity)
    return Motion(time_step_s=dt, phases=phases, hand_error_m=hand_error, **record)

"""What decides a motion, and the worker who makes it: a body with masses in its hands, its tasks and its controller."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.joint_data import MaximumTorque
from fatigue_planner.human.model import GRAVITY_MPS2, Human, Tool, Worker, build_human
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.controller import WholeBodyController
from fatigue_planner.motion.minimum_jerk import Pose, Trajectory
from fatigue_planner.motion.schedule import Run
from fatigue_planner.motion.settings import Controller, Cycle, Side
from fatigue_planner.motion.tasks.centre_of_mass import CentreOfMassTask
from fatigue_planner.motion.tasks.hand import HandTask
from fatigue_planner.motion.tasks.joint_posture import WholePosture
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.motion.tasks.task import Coordinates

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class MotionRequest:
    """Everything that decides a motion."""

    worker: Worker
    maximum_torque: MaximumTorque
    tool: Tool
    cycle: Cycle
    controller: Controller
    action: Action
    preference: Preference


class Body:
    """The worker with masses in the hands: state, tasks and controller."""

    def __init__(self, request: MotionRequest, run: Run) -> None:
        self.request, settings = request, request.controller
        weights, stiffness = settings.weights, settings.stiffness_per_s2
        self.human: Human = build_human(request.worker, run.right_kg, run.left_kg)
        self.state = state = BodyState(self.human)
        state.update(self.human.stance, np.zeros(self.human.model.nv))
        self.hand_frames = {side: state.frame(f"{side}_grip") for side in SIDES}
        self.hands: dict[Side, HandTask] = {
            side: HandTask(
                weights.hand, stiffness.hand, self.hand_frames[side], slice(6 if goal.turned() else 3),
                Trajectory.at_rest(self.hand_pose(side)),
            )
            for side, goal in request.action.goals().items()
        }  # fmt: skip
        x, y, _ = (float(value) for value in state.centre_of_mass().position_m)
        x += settings.centre_of_mass_shift_m
        self.centre_m = np.array([x, y])
        self.balance = CentreOfMassTask(weights.centre_of_mass, stiffness.centre_of_mass, Coordinates(x=x, y=y))
        posture = WholePosture(weights.posture, stiffness.posture, self.human.stance[7:])
        preferred = [task.build_stiffened(self.human, state, stiffness) for task in request.preference.tasks]
        self.first_preferred = 1 + len(self.hands)
        self.controller = WholeBodyController(
            self.human, state, settings, request.maximum_torque.vectors(), posture,
            [self.balance, *self.hands.values(), *preferred],
        )  # fmt: skip

    def lean_against(self, side: Side, force_n: Vector) -> None:
        """Shift the target of the centre of mass so that a force (3,) on a hand leaves the centre of pressure in place.

        The ground bears weight and force where it bears the weight alone, at c, if
        m g (x - c) = (p - c) F_z - p_z F_x, with x the centre of mass and p the hand (and y alike): a worker who is
        pushed leans against the push, one who lifts leans back.
        """
        point, weight = self.hand_pose(side).position_m, self.human.mass_kg * GRAVITY_MPS2
        moment = (point[:2] - self.centre_m) * force_n[2] - point[2] * force_n[:2]
        self.balance.reference_m = self.balance.reference_m + moment / weight

    def hand_pose(self, side: Side) -> Pose:
        """The pose of a hand's frame, at the centre of the fist."""
        placement = self.state.placement(self.hand_frames[side])
        return Pose(placement.translation.copy(), placement.rotation.copy())

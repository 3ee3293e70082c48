"""What decides a motion, and the worker who makes it: a body with masses in its hands, its tasks and its controller."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.joint_data import MaximumTorque
from fatigue_planner.human.model import Human, Tool, Worker
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.controller import WholeBodyController
from fatigue_planner.motion.minimum_jerk import Pose
from fatigue_planner.motion.motion import Phase
from fatigue_planner.motion.physiology.piece import Scene, TimedTask
from fatigue_planner.motion.physiology.registry import Physiology
from fatigue_planner.motion.schedule import Run, hand_reference, phases_of, rise_of, weight_factor_of
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


class Share(NamedTuple):
    """The fraction of its weight that a task, by its index, or its rows from a first one on, has at every tick (T,)."""

    task: int
    first_row: int
    share: Vector


class Body:
    """The worker with masses in the hands: state, tasks and controller.

    other_way: the hands that turn the longer way round to their work.
    """

    def __init__(self, request: MotionRequest, run: Run, other_way: frozenset[Side] = frozenset()) -> None:
        self.request, settings = request, request.controller
        weights, stiffness = settings.weights, settings.stiffness_per_s2
        self.human: Human = run.human(request.worker)
        self.state = state = BodyState(self.human)
        state.update(self.human.stance, np.zeros(self.human.model.nv))
        self.hand_frames = {side: state.frame(f"{side}_grip") for side in SIDES}
        phases, dt = phases_of(request.cycle, settings.time_step_s), settings.time_step_s
        goals = request.action.goals()
        paths = {
            side: hand_reference(self.hand_pose(side), goal, phases, dt, side in other_way)
            for side, goal in goals.items()
        }
        self.physiology = Physiology(request.worker.human, Scene(self.human, state, phases, dt, paths))
        hand_weight = self.physiology.hand_weight_factor * weights.hand
        self.hands: dict[Side, HandTask] = {
            side: HandTask(
                hand_weight, stiffness.hand, self.hand_frames[side], slice(6 if goal.turned() else 3), paths[side]
            )
            for side, goal in goals.items()
        }
        x, y, _ = (float(value) for value in state.centre_of_mass().position_m)
        x += settings.centre_of_mass_shift_m
        self.centre_m = np.array([x, y])
        self.balance = CentreOfMassTask(weights.centre_of_mass, stiffness.centre_of_mass, Coordinates(x=x, y=y))
        posture = WholePosture(weights.posture, stiffness.posture, self.human.stance[7:])
        preferred = [task.build_stiffened(self.human, state, stiffness) for task in request.preference.tasks]
        added = self.physiology.tasks()
        self.controller = WholeBodyController(
            self.human, state, settings, request.maximum_torque.vectors(), posture, self.physiology,
            [self.balance, *self.hands.values(), *preferred, *(timed.task for timed in added)],
        )  # fmt: skip
        self.shares = self._shares(phases, added)

    def _shares(self, phases: tuple[Phase, ...], added: list[TimedTask]) -> list[Share]:
        """The tasks whose weight changes during the cycle.

        A human with a way home of his own lets go of the work as that says, whatever `return_hand` is.
        """
        cycle, dt, ticks = self.request.cycle, self.request.controller.time_step_s, phases[-1].stop
        aim, first = self.physiology.aim(), 1 + len(self.hands)
        aiming = np.ones(ticks) if aim is None else aim
        factors = [weight_factor_of(task.during, phases, dt) for task in self.request.preference.tasks]
        own = [aiming if factor is None else aiming * factor for factor in factors]
        own += [share * aiming if aims else share for _, share, aims in added]
        released, first_released = aiming.copy(), 0
        if aim is None and cycle.return_hand != "pose":
            released[phases[-1].start :] *= 1 - rise_of(phases[-1], dt)
            first_released = 0 if cycle.return_hand == "free" else 3
        shares = [Share(index, first_released, released) for index in range(1, first)]
        shares += [Share(first + index, 0, share) for index, share in enumerate(own)]
        return [share for share in shares if (share.share != 1).any()]

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

"""One cycle of the digital human: reach, work, return."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.joint_data import MaximumTorque
from fatigue_planner.human.model import GRAVITY_MPS2, Human, Tool, Worker, build_human
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.action import Action
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.controller import WholeBodyController
from fatigue_planner.motion.failure import failure
from fatigue_planner.motion.minimum_jerk import Pose, Trajectory
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.references import hand_reference
from fatigue_planner.motion.schedule import Run, forces_of, phases_of, rise_of, runs_of, share_of
from fatigue_planner.motion.settings import Controller, Cycle, Side
from fatigue_planner.motion.tasks.centre_of_mass import CentreOfMassTask
from fatigue_planner.motion.tasks.coordinates import Coordinates
from fatigue_planner.motion.tasks.hand import HandTask
from fatigue_planner.motion.tasks.joint_posture import WholePosture
from fatigue_planner.motion.tasks.registry import Preference

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
        settings = request.controller
        weights, stiffness = settings.weights, settings.stiffness_per_s2
        self.human: Human = build_human(request.worker, run.right_kg, run.left_kg)
        self.state = state = BodyState(self.human)
        state.update(self.human.stance, np.zeros(self.human.model.nv))
        self.grips = {side: state.frame(f"{side}_grip") for side in SIDES}
        self.hands: dict[Side, HandTask] = {
            side: HandTask(
                weights.hand, stiffness.hand, self.grips[side], slice(6 if goal.turned() else 3),
                Trajectory.at_rest(self.fist(side)),
            )
            for side, goal in request.action.goals().items()
        }  # fmt: skip
        x, y, _ = (float(value) for value in state.centre_of_mass().position_m)
        x += settings.centre_of_mass_shift_m
        self.centre_m = np.array([x, y])
        self.balance = CentreOfMassTask(weights.centre_of_mass, stiffness.centre_of_mass, Coordinates(x=x, y=y))
        posture = WholePosture(weights.posture, stiffness.posture, self.human.stance[7:])
        preferred = [task.build(self.human, state, stiffness) for task in request.preference.tasks]
        self.first_preferred = 1 + len(self.hands)
        self.controller = WholeBodyController(
            self.human, state, settings, request.maximum_torque.vectors(), posture,
            [self.balance, *self.hands.values(), *preferred],
        )  # fmt: skip

    def lean_against(self, side: Side, force_n: Vector) -> None:
        """Shift the place of the centre of mass so that a force (3,) on a fist leaves the pressure where it is.

        The ground bears weight and force where it bears the weight alone, at c, if
        m g (x - c) = (p - c) F_z - p_z F_x, with x the centre of mass and p the fist (and y alike): who is pushed
        leans against it, who lifts leans back.
        """
        at, weight = self.fist(side).position_m, self.human.mass_kg * GRAVITY_MPS2
        moment = (at[:2] - self.centre_m) * force_n[2] - at[2] * force_n[:2]
        self.balance.reference_m = self.balance.reference_m + moment / weight

    def fist(self, side: Side) -> Pose:
        """Where a fist is."""
        placement = self.state.placement(self.grips[side])
        return Pose(placement.translation.copy(), placement.rotation.copy())


class Simulator:
    """The digital human at a tick of a cycle: `prepare` evaluates it, `advance` moves it to the next."""

    def __init__(self, request: MotionRequest) -> None:
        self.request = request
        self.time_step_s = dt = request.controller.time_step_s
        self.phases = phases_of(request.cycle, dt)
        self.ticks = self.phases[-1].stop
        self.runs = runs_of(request.tool, request.action, self.phases)
        self.forces = forces_of(request.action, self.ticks, dt)
        shares = [share_of(task.during, self.phases, dt) for task in request.preference.tasks]
        self._turned_share = np.ones(self.ticks)
        if request.cycle.return_hand == "position":
            self._turned_share[self.phases[-1].start :] = 1 - rise_of(self.phases[-1], dt)
        self._switched = [(place, share) for place, share in enumerate(shares) if share is not None]
        self.body = Body(request, self.runs[0])
        self.references = {
            side: hand_reference(self.body.fist(side), goal, self.phases, dt)
            for side, goal in request.action.goals().items()
        }
        self._hand_over()
        self.configuration, self.velocity = self.body.human.stance.copy(), np.zeros(self.body.human.model.nv)

    def take_up(self, run: Run) -> None:
        """Change the masses in the hands."""
        self.body = Body(self.request, run)
        self._hand_over()

    def _hand_over(self) -> None:
        for side, task in self.body.hands.items():
            task.reference = self.references[side]

    def prepare(self, tick: int) -> Vector:
        """Evaluate the body, its references and the forces at a tick; returns the forces on the fists (6,)."""
        body = self.body
        body.state.update(self.configuration, self.velocity)
        body.balance.reference_m = body.centre_m
        pushed = np.zeros(6)
        for planned in self.forces:
            turn = body.state.placement(body.grips[planned.hand]).rotation if planned.in_hand_axes else np.eye(3)
            force = turn @ planned.force_n[tick]
            body.state.push(body.grips[planned.hand], force)
            body.lean_against(planned.hand, force)
            pushed[3 * SIDES.index(planned.hand) :][:3] += force
        for place, task in enumerate(body.hands.values(), start=1):
            task.moment = tick
            body.controller.weigh(place, self._turned_share[tick], first_row=3)
        for place, share in self._switched:
            body.controller.weigh(body.first_preferred + place, share[tick])
        return pushed

    def advance(self, acceleration: Vector) -> None:
        """A semi-implicit Euler step on the configuration manifold."""
        self.velocity = self.velocity + self.time_step_s * acceleration
        self.configuration = pin.integrate(
            self.body.human.model, self.configuration, self.time_step_s * self.velocity
        )  # fmt: skip

    def fists(self) -> Vector:
        """Where the fists with a goal are, (3 per hand,) m."""
        state, grips = self.body.state, self.body.grips
        return np.concatenate([state.placement(grips[side]).translation for side in self.references])


def simulate(request: MotionRequest) -> Motion:
    """Simulate one cycle from the natural stance.

    Raises FailedMotionError, naming time, phase, tick, the limit in the way and advice, if the program
    has no solution at some tick, even with the bounds of the joint accelerations eased.
    """
    simulator = Simulator(request)
    nv = simulator.velocity.size
    widths = {
        "configuration": nv + 1, "velocity": nv, "acceleration": nv, "torque_nm": nv - 6, "wrench": 12,
        "hand_force_n": 6, "eased_radps2": nv - 6,
    }  # fmt: skip
    record = {name: np.empty((simulator.ticks, width)) for name, width in widths.items()}
    fists = np.empty((simulator.ticks, 3 * len(simulator.references)))
    for run in simulator.runs:
        if run.start > 0:
            simulator.take_up(run)
        for tick in range(run.start, run.stop):
            force = simulator.prepare(tick)
            result = simulator.body.controller.step()
            if result is None:
                raise failure(simulator, tick, record["torque_nm"][:tick])
            record["configuration"][tick], record["velocity"][tick] = simulator.configuration, simulator.velocity
            record["acceleration"][tick], record["torque_nm"][tick] = result.acceleration, result.torque_nm
            record["wrench"][tick], record["hand_force_n"][tick] = result.wrench, force
            record["eased_radps2"][tick] = result.eased_radps2
            fists[tick] = simulator.fists()
            simulator.advance(result.acceleration)
    wanted = np.concatenate([reference.position_m for reference in simulator.references.values()], axis=1)
    errors = np.linalg.norm((fists - wanted).reshape(simulator.ticks, -1, 3), axis=2)
    return Motion(time_step_s=simulator.time_step_s, phases=simulator.phases, hand_error_m=errors.max(axis=1), **record)

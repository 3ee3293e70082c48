"""One cycle of the digital human: reach, work, return."""

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.body import Body, MotionRequest
from fatigue_planner.motion.failure import failure
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.schedule import (
    Run,
    forces_of,
    hand_reference,
    phases_of,
    rise_of,
    runs_of,
    weight_factor_of,
)

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


class Simulator:
    """The digital human at a tick of a cycle: `prepare` evaluates it, `advance` moves it to the next."""

    def __init__(self, request: MotionRequest) -> None:
        self.request = request
        self.time_step_s = dt = request.controller.time_step_s
        self.phases = phases_of(request.cycle, dt)
        self.ticks = self.phases[-1].stop
        self.runs = runs_of(request.tool, request.action, self.phases)
        self.forces = forces_of(request.action, self.ticks, dt)
        factors = [weight_factor_of(task.during, self.phases, dt) for task in request.preference.tasks]
        self._led = np.ones(self.ticks)  # the share of their weight that the released rows of the hands' tasks have
        if request.cycle.return_hand != "pose":
            self._led[self.phases[-1].start :] = 1 - rise_of(self.phases[-1], dt)
        self._first_released = 0 if request.cycle.return_hand == "free" else 3
        self._switched = [(index, factor) for index, factor in enumerate(factors) if factor is not None]
        self.body = Body(request, self.runs[0])
        self.references = {
            side: hand_reference(self.body.hand_pose(side), goal, self.phases, dt)
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
        """Evaluate the body, its references and the forces at a tick; returns the forces on the hands (6,)."""
        body = self.body
        body.state.update(self.configuration, self.velocity)
        body.balance.reference_m = body.centre_m
        forces = np.zeros(6)
        for planned in self.forces:
            turn = body.state.placement(body.hand_frames[planned.hand]).rotation if planned.in_hand_axes else np.eye(3)
            force = turn @ planned.force_n[tick]
            body.state.push(body.hand_frames[planned.hand], force)
            body.lean_against(planned.hand, force)
            forces[3 * SIDES.index(planned.hand) :][:3] += force
        for index, task in enumerate(body.hands.values(), start=1):
            task.index = tick
            body.controller.weigh(index, self._led[tick], self._first_released)
        for index, factor in self._switched:
            body.controller.weigh(body.first_preferred + index, factor[tick])
        return forces

    def advance(self, acceleration: Vector) -> None:
        """A semi-implicit Euler step on the configuration manifold."""
        self.velocity = self.velocity + self.time_step_s * acceleration
        self.configuration = pin.integrate(
            self.body.human.model, self.configuration, self.time_step_s * self.velocity
        )  # fmt: skip

    def hand_positions(self) -> Vector:
        """The positions of the hands with a goal, (3 per hand,) m."""
        state, frames = self.body.state, self.body.hand_frames
        return np.concatenate([state.placement(frames[side]).translation for side in self.references])


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
    positions = np.empty((simulator.ticks, 3 * len(simulator.references)))
    for run in simulator.runs:
        if run.start > 0:
            simulator.take_up(run)
        for tick in range(run.start, run.stop):
            force = simulator.prepare(tick)
            result = simulator.body.controller.step()
            if result is None:
                raise failure(simulator.body, tick, record["torque_nm"][:tick])
            record["configuration"][tick], record["velocity"][tick] = simulator.configuration, simulator.velocity
            record["acceleration"][tick], record["torque_nm"][tick] = result.acceleration, result.torque_nm
            record["wrench"][tick], record["hand_force_n"][tick] = result.wrench, force
            record["eased_radps2"][tick] = result.eased_radps2
            positions[tick] = simulator.hand_positions()
            simulator.advance(result.acceleration)
    wanted = np.concatenate([reference.position_m for reference in simulator.references.values()], axis=1)
    errors = np.linalg.norm((positions - wanted).reshape(simulator.ticks, -1, 3), axis=2)
    return Motion(time_step_s=simulator.time_step_s, phases=simulator.phases, hand_error_m=errors.max(axis=1), **record)

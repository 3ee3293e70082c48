"""One cycle of the digital human: reach, work, return."""

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.body import Body, MotionRequest
from fatigue_planner.motion.failure import failure
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.physiology.hand_turn import effort, ways_round
from fatigue_planner.motion.schedule import Run, forces_of, phases_of, runs_of
from fatigue_planner.motion.settings import Side

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


class Simulator:
    """The digital human at a tick of a cycle: `prepare` evaluates it, `advance` moves it to the next."""

    def __init__(self, request: MotionRequest, other_way: frozenset[Side] = frozenset()) -> None:
        self.request, self.other_way = request, other_way
        self.time_step_s = dt = request.controller.time_step_s
        self.phases = phases_of(request.cycle, dt)
        self.ticks = self.phases[-1].stop
        self.runs = runs_of(request.tool, request.action, self.phases)
        self.forces = forces_of(request.action, self.ticks, dt)
        self.body = Body(request, self.runs[0], other_way)
        self.configuration, self.velocity = self.body.human.stance.copy(), np.zeros(self.body.human.model.nv)

    def take_up(self, run: Run) -> None:
        """Change the masses in the hands."""
        self.body = Body(self.request, run, self.other_way)

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
        for task in body.hands.values():
            task.index = tick
        for index, first_row, share in body.shares:
            body.controller.weigh(index, share[tick], first_row)
        body.physiology.prepare(tick)
        return forces

    def advance(self, acceleration: Vector) -> None:
        """A semi-implicit Euler step on the configuration manifold."""
        self.velocity = self.velocity + self.time_step_s * acceleration
        self.configuration = pin.integrate(
            self.body.human.model, self.configuration, self.time_step_s * self.velocity
        )  # fmt: skip

    def hand_positions(self) -> Vector:
        """The positions of the hands with a goal, (3 per hand,) m."""
        return np.concatenate([self.body.state.placement(task.frame).translation for task in self.body.hands.values()])


def simulate(request: MotionRequest) -> Motion:
    """Simulate one cycle from the natural stance.

    Raises FailedMotionError, naming time, phase, tick, the limit in the way and advice, if the program
    has no solution at some tick, even with the bounds of the joint accelerations eased; where hands may turn either
    way round, that of the shorter way, if no way has one.
    """
    simulator = Simulator(request)
    body, work = simulator.body, simulator.phases[1].start
    if not body.physiology.turns_either_way:
        return _simulated(simulator)
    motions, failures = [], []
    for other_way in ways_round({side: task.reference for side, task in body.hands.items()}, work):
        try:
            motions.append(_simulated(Simulator(request, other_way) if other_way else simulator))
        except FailedMotionError as error:
            failures.append(error)
    if not motions:
        raise failures[0]
    strength = request.maximum_torque.vectors()
    return min(motions, key=lambda motion: effort(motion.torque_nm, *strength))


def _simulated(simulator: Simulator) -> Motion:
    nv = simulator.velocity.size
    widths = {
        "configuration": nv + 1, "velocity": nv, "acceleration": nv, "torque_nm": nv - 6, "wrench": 12,
        "hand_force_n": 6, "eased_radps2": nv - 6, "tissue_nm": nv - 6,
    }  # fmt: skip
    record = {name: np.empty((simulator.ticks, width)) for name, width in widths.items()}
    hands = simulator.body.hands.values()
    positions = np.empty((simulator.ticks, 3 * len(hands)))
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
            record["eased_radps2"][tick], record["tissue_nm"][tick] = result.eased_radps2, result.tissue_nm
            positions[tick] = simulator.hand_positions()
            simulator.advance(result.acceleration)
    wanted = np.concatenate([task.reference.position_m for task in hands], axis=1)
    errors = np.linalg.norm((positions - wanted).reshape(simulator.ticks, -1, 3), axis=2)
    return Motion(time_step_s=simulator.time_step_s, phases=simulator.phases, hand_error_m=errors.max(axis=1), **record)

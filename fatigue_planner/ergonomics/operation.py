"""What an indicator looks at: one or more operations of a worker that make a cycle."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.ergonomics.posture import PostureCourse
from fatigue_planner.ergonomics.result import Phrase, Unknown
from fatigue_planner.ergonomics.stated import Circumstances, Shift
from fatigue_planner.human.multibody import GRAVITY_MPS2
from fatigue_planner.human.skeleton import SIDES
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.schedule import runs_of
from fatigue_planner.reactions.reaction import Reaction

Matrix = NDArray[np.float64]

# How far apart the instants are that are judged, in s.
STEP_S = 0.1


@dataclass(frozen=True)
class Operation:
    """One operation: how it is called, what the worker does, and what is stated of it.

    step_s: how far apart the instants are that are judged; 0 is every tick.
    """

    name: str
    request: MotionRequest
    motion: Motion
    stated: Circumstances = field(default_factory=Circumstances)
    step_s: float = STEP_S

    @classmethod
    def of(
        cls, reaction: Reaction, stated: Circumstances | None = None, name: str = "", step_s: float = STEP_S
    ) -> Self:
        """The operation that a reaction is; its name by default the reaction's."""
        request = reaction.key.motion_request()
        return cls(name or str(reaction.name), request, reaction.motion, stated or Circumstances(), step_s)

    @property
    def duration_s(self) -> float:
        """How long the operation lasts once."""
        return len(self.motion.configuration) * self.motion.time_step_s

    @property
    def seconds_per_cycle(self) -> float:
        """How long the operation lasts in a cycle, with all its repetitions."""
        return self.duration_s * self.stated.times_per_cycle

    @cached_property
    def works(self) -> NDArray[np.bool_]:
        """Which sides work, (2,): those with a goal. What is stated of the working arm is true of them alone."""
        return np.array([side in self.request.action.goals() for side in SIDES])

    @cached_property
    def posture(self) -> PostureCourse:
        """The posture every `step_s`."""
        return PostureCourse.of(self.request.worker.anthropometry(), self.motion, self.step_s)

    @cached_property
    def stride(self) -> int:
        """Ticks from one instant that is judged to the next."""
        return round(self.posture.step_s / self.motion.time_step_s)

    @cached_property
    def load_kg(self) -> Matrix:
        """What each hand bears at every instant, (n, 2): stated, else masses and forces / g of the simulation.

        A stated load is shared by the hands that have a goal.
        """
        if self.stated.load_kg is not None:
            goals = self.request.action.goals()
            share = [self.stated.load_kg / len(goals) if side in goals else 0.0 for side in SIDES]
            return np.tile(share, (len(self.posture.time_s), 1))
        forces = np.linalg.norm(self.motion.hand_force_n[:: self.stride].reshape(-1, len(SIDES), 3), axis=2)
        return np.asarray(self.held_kg + forces / GRAVITY_MPS2)

    @cached_property
    def held_kg(self) -> Matrix:
        """The masses that the simulated hands hold at every instant, (n, 2)."""
        held = np.zeros((len(self.motion.configuration), len(SIDES)))
        for run in runs_of(self.request.tool, self.request.action, self.motion.phases):
            held[run.start : run.stop] = run.right_kg, run.left_kg
        return held[:: self.stride]

    @cached_property
    def torque_share(self) -> Matrix:
        """Torques as signed shares of the worker's strength in their direction, at every instant, (n, 39)."""
        positive, negative = self.request.maximum_torque.vectors()
        torque = self.motion.torque_nm[:: self.stride]
        return np.asarray(torque / np.where(torque >= 0, positive, negative))


# What an unknown number of actions of the hand may be, per minute of the operation: slow, brisk, very fast (assumed).
ACTIONS = (
    (10.0, Phrase("with 10 actions a minute")), (30.0, Phrase("with 30 actions a minute")),
    (60.0, Phrase("with 60 actions a minute")),
)  # fmt: skip


@dataclass(frozen=True)
class Job:
    """The operations of one cycle, in any order, and the shift. Raises DataFileError if they take longer than it."""

    operations: Sequence[Operation]
    shift: Shift = field(default_factory=Shift)

    def __post_init__(self) -> None:
        """See Job."""
        if self.shift.cycle_s is not None and self.busy_s > self.shift.cycle_s * (1 + 1e-9):
            raise DataFileError(
                f"cycle_s = {self.shift.cycle_s:g} s is shorter than its operations, {self.busy_s:g} s together."
            )

    @property
    def busy_s(self) -> float:
        """How long all operations of a cycle take."""
        return sum(operation.seconds_per_cycle for operation in self.operations)

    def working_with(self, side: str) -> list[Operation]:
        """The operations in which the hand of a side works."""
        return [operation for operation in self.operations if side in operation.request.action.goals()]

    def times_per_minute(self, operation: Operation) -> float:
        """How often an operation is done in a minute, as far as is stated; 0 if the length of the cycle is not."""
        return 60 * operation.stated.times_per_cycle / self.shift.cycle_s if self.shift.cycle_s else 0.0

    def uncounted(self) -> list[Unknown]:
        """The number of actions as an input that is unknown, if it is not stated of some operation: 0 is one effort."""
        if all(operation.stated.actions_per_minute is not None for operation in self.operations):
            return []
        return [Unknown("actions_per_minute", 0.0, ACTIONS)]

    @property
    def cycle_s(self) -> float:
        """How long a cycle takes; all operations one after another if it is not stated."""
        return self.shift.cycle_s or self.busy_s

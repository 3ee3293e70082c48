"""Move a hand: along a reference (actions) or to a fixed pose (preferences)."""

from typing import Literal, Self

import numpy as np
import pinocchio as pin
from pydantic import Field, model_validator

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.model import Human
from fatigue_planner.motion.action import Orientation, Position
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.minimum_jerk import Pose, Trajectory
from fatigue_planner.motion.settings import Side, Stiffnesses
from fatigue_planner.motion.tasks.task import Matrix, PreferenceTask, Task, Vector


class HandTask(Task):
    """Follow a trajectory with a fist: its position, its orientation, or both.

    `index` is the row of the trajectory that is the present reference.
    """

    def __init__(self, weight: float, stiffness: float, frame: int, parts: slice, reference: Trajectory) -> None:
        super().__init__(len(range(6)[parts]), weight, stiffness)
        self.frame = frame
        self.parts = parts
        self.reference = reference
        self.index = 0

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        placement, whole = state.placement(self.frame), state.jacobian(self.frame)
        reference, index = self.reference, self.index
        error = np.empty(6)
        error[:3] = reference.position_m[index] - placement.translation
        error[3:] = pin.log3(reference.rotation[index] @ placement.rotation.T)
        jacobian[:] = whole[self.parts]
        desired = _desired(
            whole, state.velocity, state.drift(self.frame), error,
            reference.velocity[index], reference.acceleration[index], self.stiffness, self.damping,
        )  # fmt: skip
        target[:] = desired[self.parts]


@compiled
def _desired(
    jacobian: Matrix, velocity: Vector, drift: Vector, error: Vector, wanted_velocity: Vector,
    wanted_acceleration: Vector, stiffness: float, damping: float,
) -> Vector:  # fmt: skip
    """desired - drift (6,) of a frame with a moving reference."""
    twist = jacobian @ velocity
    return wanted_acceleration + damping * (wanted_velocity - twist) + stiffness * error - drift


class Hand(PreferenceTask):
    """Settings of a HandTask with a fixed reference; what is not given is free."""

    kind: Literal["hand"] = Field(description="Hold a hand at a position, in an orientation, or both.")
    hand: Side = Field(description="The hand that is held.")
    position_m: Position | None = Field(default=None, description="Position of the fist's centre in m; left out, free.")
    orientation_deg: Orientation | None = Field(
        default=None, description="Orientation of the hand in degrees; left out, free."
    )

    @model_validator(mode="after")
    def _check_some(self) -> Self:
        if self.position_m is None and self.orientation_deg is None:
            raise ValueError("give position_m, orientation_deg or both")
        return self

    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """See PreferenceTask.build."""
        position, turn = self.position_m, self.orientation_deg
        parts = slice(0 if position else 3, 6 if turn else 3)
        pose = Pose(position.vector() if position else np.zeros(3), turn.rotation() if turn else np.eye(3))
        frame = state.frame(f"{self.hand}_grip")
        return HandTask(self.weight, stiffness.hand, frame, parts, Trajectory.at_rest(pose))

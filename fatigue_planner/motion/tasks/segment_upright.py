"""Keep a segment's long axis vertical."""

from typing import Literal

import numpy as np
from pydantic import Field

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.model import Human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.settings import Segment, Stiffnesses
from fatigue_planner.motion.tasks.task import Matrix, PreferenceTask, Task, Vector

UP = np.array([0.0, 0.0, 1.0])


class SegmentUprightTask(Task):
    """Keep a segment's long axis (its z axis) in a direction (3,) of the world; the rotation about it is free.

    The error is the rotation vector from the axis e to the direction d, e x d. All three world
    components are written; the angular acceleration about e is taken out of the rows.
    """

    def __init__(self, weight: float, stiffness: float, frame: int, direction: Vector) -> None:
        super().__init__(3, weight, stiffness)
        self.frame, self.direction = frame, direction

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        axis = state.placement(self.frame).rotation[:, 2]
        whole, drift = state.jacobian(self.frame), state.drift(self.frame)
        _write_rows(axis, self.direction, whole, state.velocity, drift, self.stiffness, self.damping, jacobian, target)


@compiled
def _write_rows(
    axis: Vector, wanted: Vector, whole: Matrix, velocity: Vector, drift: Vector, stiffness: float, damping: float,
    jacobian: Matrix, target: Vector,
) -> None:  # fmt: skip
    """Write the rows of the task from the segment's axis (3,), Jacobian (6, 45) and drift (6,)."""
    error = np.array([
        axis[1] * wanted[2] - axis[2] * wanted[1],
        axis[2] * wanted[0] - axis[0] * wanted[2],
        axis[0] * wanted[1] - axis[1] * wanted[0],
    ])  # fmt: skip
    missing = stiffness * error - damping * (whole @ velocity)[3:] - drift[3:]
    along = axis[0] * missing[0] + axis[1] * missing[1] + axis[2] * missing[2]
    target[:] = missing - axis * along
    for j in range(whole.shape[1]):
        about = axis[0] * whole[3, j] + axis[1] * whole[4, j] + axis[2] * whole[5, j]
        for i in range(3):
            jacobian[i, j] = whole[3 + i, j] - axis[i] * about


class SegmentUpright(PreferenceTask):
    """Settings of SegmentUprightTask."""

    kind: Literal["segment_upright"] = Field(description="Keep a segment's long axis vertical.")
    segment: Segment = Field(description="The body segment; it may turn about its long axis.")

    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """See PreferenceTask.build."""
        return SegmentUprightTask(self.weight, stiffness.segment, state.frame(self.segment), UP)

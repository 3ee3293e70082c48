"""Keep a segment's long axis vertical."""

from typing import Literal

import numpy as np

from fatigue_planner.human.model import Human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.settings import Segment, Stiffnesses
from fatigue_planner.motion.tasks.task import Matrix, PreferenceTask, Task, Vector

_IDENTITY: Matrix = np.eye(3)


class SegmentUprightTask(Task):
    """Keep a segment's long axis (its z axis) vertical; the rotation about it is free.

    The error is the rotation vector from the axis e to the vertical, e x up. All three world
    components are written; the angular acceleration about e is taken out of the rows.
    """

    def __init__(self, weight: float, stiffness: float, frame: int) -> None:
        super().__init__(3, weight, stiffness)
        self.frame = frame

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        axis = state.placement(self.frame).rotation[:, 2]
        across = _IDENTITY - axis[:, None] * axis
        error = np.array([axis[1], -axis[0], 0.0])  # axis x up
        desired = self.stiffness * error - self.damping * state.twist(self.frame)[3:]
        jacobian[:] = across @ state.jacobian(self.frame)[3:]
        target[:] = across @ (desired - state.drift(self.frame)[3:])


class SegmentUpright(PreferenceTask):
    """Settings of SegmentUprightTask."""

    kind: Literal["segment_upright"]
    segment: Segment

    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """See PreferenceTask.build."""
        return SegmentUprightTask(self.weight, stiffness.segment, state.frame(self.segment))

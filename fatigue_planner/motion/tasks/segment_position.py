"""Keep a segment's upper joint at a position."""

from typing import Literal

from pydantic import Field

from fatigue_planner.human.model import Human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.settings import Segment, Stiffnesses
from fatigue_planner.motion.tasks.task import Coordinates, Matrix, PreferenceTask, Task, Vector


class SegmentPositionTask(Task):
    """Keep the origin of a segment (its upper joint; the pelvis' is the middle of the hips) at a position."""

    def __init__(self, weight: float, stiffness: float, frame: int, position: Coordinates) -> None:
        super().__init__(len(position.axes()), weight, stiffness)
        self.frame = frame
        self.axes, self.reference_m = position.axes(), position.values()

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        axes = self.axes
        error = self.reference_m - state.placement(self.frame).translation[axes]
        jacobian[:] = state.jacobian(self.frame)[axes]
        target[:] = self.stiffness * error - self.damping * state.twist(self.frame)[axes]
        target -= state.drift(self.frame)[axes]


class SegmentPosition(PreferenceTask):
    """Settings of SegmentPositionTask."""

    kind: Literal["segment_position"] = Field(description="Keep a segment's upper joint at a position.")
    segment: Segment = Field(description="The body segment; the pelvis is held at the middle of the hips.")
    position_m: Coordinates = Field(description="Position of the segment's upper joint in m.")

    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """See PreferenceTask.build."""
        return SegmentPositionTask(self.weight, stiffness.segment, state.frame(self.segment), self.position_m)

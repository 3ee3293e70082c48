"""Keep a segment in an orientation."""

from typing import Literal

import pinocchio as pin
from pydantic import Field

from fatigue_planner.human.model import Human
from fatigue_planner.motion.action import Orientation
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.settings import Segment, Stiffnesses
from fatigue_planner.motion.tasks.task import Matrix, PreferenceTask, Task, Vector


class SegmentOrientationTask(Task):
    """Keep a segment in an orientation of the world; the error is the rotation vector to it."""

    def __init__(self, weight: float, stiffness: float, frame: int, rotation: Matrix) -> None:
        super().__init__(3, weight, stiffness)
        self.frame = frame
        self.rotation = rotation

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        turn = pin.log3(self.rotation @ state.placement(self.frame).rotation.T)
        jacobian[:] = state.jacobian(self.frame)[3:]
        target[:] = self.stiffness * turn - self.damping * state.twist(self.frame)[3:] - state.drift(self.frame)[3:]


class SegmentOrientation(PreferenceTask):
    """Settings of SegmentOrientationTask."""

    kind: Literal["segment_orientation"] = Field(description="Keep a segment in an orientation.")
    segment: Segment = Field(description="The body segment.")
    orientation_deg: Orientation = Field(description="Orientation in degrees; all 0 is that of the standing worker.")

    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """See PreferenceTask.build."""
        rotation = self.orientation_deg.rotation()
        return SegmentOrientationTask(self.weight, stiffness.segment, state.frame(self.segment), rotation)

"""Your own motion task: keep the head at a given height.

As a plug-in (`fatplan simulate mine.yaml --plugin examples/own_motion_task.py`) a preference of an experiment file can
name it: `{kind: head_height, weight: 10, height_m: 1.4, during: [work]}`.
"""

from typing import Literal

from pydantic import Field

import fatigue_planner as fp


class HeadHeightTask(fp.Task):
    """One row: the vertical acceleration of the head."""

    def __init__(self, weight: float, stiffness: float, frame: int, height_m: float) -> None:
        super().__init__(1, weight, stiffness)
        self.frame, self.height_m = frame, height_m

    def evaluate(self, state, jacobian, target) -> None:
        """See Task.evaluate."""
        jacobian[:] = state.jacobian(self.frame)[2:3]
        error = self.height_m - state.placement(self.frame).translation[2]
        speed = state.twist(self.frame)[2]
        target[:] = self.stiffness * error - self.damping * speed - state.drift(self.frame)[2]


@fp.register
class HeadHeight(fp.PreferenceTask):
    """Settings of HeadHeightTask."""

    kind: Literal["head_height"]
    height_m: float = Field(gt=0, le=2.5, description="Height of the head's centre above the ground, m.")

    def build(self, human, state, stiffness) -> fp.Task:
        """See PreferenceTask.build."""
        return HeadHeightTask(self.weight, stiffness.segment, state.frame("head"), self.height_m)

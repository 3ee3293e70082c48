"""Draw joints to angles."""

from typing import Literal

import numpy as np
from pydantic import Field

from fatigue_planner.human.joint_data import degrees_of_freedom, posture
from fatigue_planner.human.model import Human
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.settings import Stiffnesses
from fatigue_planner.motion.tasks.task import Matrix, PreferenceTask, Task, Vector


class WholePosture:
    """Draw all joints to a posture. No Task: its Jacobian is the identity, which the controller adds by itself."""

    def __init__(self, weight: float, stiffness: float, posture_rad: Vector) -> None:
        self.weight, self.stiffness, self.posture_rad = weight, stiffness, posture_rad

    def target(self, state: BodyState) -> Vector:
        """The joint accelerations wanted, (39,)."""
        error = self.posture_rad - state.configuration[7:]
        return np.asarray(self.stiffness * error - 2 * np.sqrt(self.stiffness) * state.velocity[BASE_DOF:])


class JointPostureTask(Task):
    """Draw some joints to angles."""

    def __init__(self, weight: float, stiffness: float, joints: list[int], angles_rad: Vector) -> None:
        super().__init__(len(joints), weight, stiffness)
        self.joints, self.angles_rad = np.array(joints), angles_rad

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        jacobian[:] = 0
        jacobian[np.arange(self.rows), BASE_DOF + self.joints] = 1
        error = self.angles_rad - state.configuration[7 + self.joints]
        target[:] = self.stiffness * error - self.damping * state.velocity[BASE_DOF + self.joints]


class JointPosture(PreferenceTask):
    """Settings of JointPostureTask: degrees by degree of freedom; a name without side means both sides."""

    kind: Literal["joint_posture"] = Field(description="Draw joints to angles.")
    angles_deg: dict[str, float] = Field(
        min_length=1, description="Angles in degrees by degree of freedom; a name without right_ or left_ means both."
    )

    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """See PreferenceTask.build."""
        angles = posture(self.angles_deg, "angles_deg")
        joints = sorted({index for name in self.angles_deg for index in degrees_of_freedom(name)})
        return JointPostureTask(self.weight, stiffness.posture, joints, angles[joints])

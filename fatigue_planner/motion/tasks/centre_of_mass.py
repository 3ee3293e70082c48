"""Hold the centre of mass at a position."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.model import Human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.settings import Stiffnesses
from fatigue_planner.motion.tasks.task import Coordinates, Matrix, PreferenceTask, Task, Vector

Indices = NDArray[np.intp]


class CentreOfMassTask(Task):
    """Hold some coordinates of the centre of mass."""

    def __init__(self, weight: float, stiffness: float, position: Coordinates) -> None:
        super().__init__(len(position.axes()), weight, stiffness)
        self.axes, self.reference_m = np.array(position.axes()), position.values()

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        centre = state.centre_of_mass()
        _write_rows(
            centre.position_m, centre.velocity, centre.drift, centre.jacobian,
            self.axes, self.reference_m, self.stiffness, self.damping, jacobian, target,
        )  # fmt: skip


@compiled
def _write_rows(
    position: Vector, velocity: Vector, drift: Vector, whole: Matrix, axes: Indices, reference: Vector,
    stiffness: float, damping: float, jacobian: Matrix, target: Vector,
) -> None:  # fmt: skip
    """Write the rows of the coordinates `axes` of the centre of mass."""
    for row in range(len(axes)):
        axis = axes[row]
        target[row] = stiffness * (reference[row] - position[axis]) - damping * velocity[axis] - drift[axis]
        for j in range(whole.shape[1]):
            jacobian[row, j] = whole[axis, j]


class CentreOfMass(PreferenceTask):
    """Settings of a CentreOfMassTask beside the one every motion has."""

    kind: Literal["centre_of_mass"] = Field(description="Hold the centre of mass at a position.")
    position_m: Coordinates = Field(description="Position of the body's centre of mass in m.")

    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """See PreferenceTask.build."""
        return CentreOfMassTask(self.weight, stiffness.centre_of_mass, self.position_m)

"""Hold the centre of mass at a place."""

from typing import Literal

from fatigue_planner.human.model import Human
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.settings import Stiffnesses
from fatigue_planner.motion.tasks.coordinates import Coordinates
from fatigue_planner.motion.tasks.task import Matrix, PreferenceTask, Task, Vector


class CentreOfMassTask(Task):
    """Hold some coordinates of the centre of mass."""

    def __init__(self, weight: float, stiffness: float, place: Coordinates) -> None:
        super().__init__(len(place.axes()), weight, stiffness)
        self.axes, self.reference_m = place.axes(), place.values()

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        centre, axes = state.centre_of_mass(), self.axes
        jacobian[:] = centre.jacobian[axes]
        error = self.reference_m - centre.position_m[axes]
        target[:] = self.stiffness * error - self.damping * centre.velocity[axes] - centre.drift[axes]


class CentreOfMass(PreferenceTask):
    """Settings of a CentreOfMassTask beside the one every motion has."""

    kind: Literal["centre_of_mass"]
    position_m: Coordinates

    def build(self, human: Human, state: BodyState, stiffness: Stiffnesses) -> Task:
        """See PreferenceTask.build."""
        return CentreOfMassTask(self.weight, stiffness.centre_of_mass, self.position_m)

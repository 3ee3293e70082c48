"""The pelvis faces where the feet point: people who stand hardly turn it for reaching."""

import numpy as np

from fatigue_planner.core.jit import compiled
from fatigue_planner.motion.body_state import BodyState
from fatigue_planner.motion.physiology.piece import Matrix, Piece, Scene, TimedTask, Vector
from fatigue_planner.motion.physiology.range_weights import REFERENCE_RAD, SPINE_FACTOR
from fatigue_planner.motion.tasks.task import Task

# How far people can turn the pelvis over feet that stand, from one side to the other: to one side 64 degrees, of which
# leaning by 45 degrees takes 25.5 or 40 % (Montgomery 2011, abstract).
RANGE_RAD = 2 * np.radians(64)
# Weighed as the spine's turning, of which it is the lower part, and as soft as the posture.
WEIGHT = SPINE_FACTOR * float(REFERENCE_RAD / RANGE_RAD) ** 2
STIFFNESS_PER_S2 = 4.0


class FacingTask(Task):
    """Turn a body about the vertical until its left side points to the world's left.

    The row is the vertical component of the angular acceleration: that of the heading while the left side is level.
    """

    def __init__(self, weight: float, stiffness: float, frame: int) -> None:
        super().__init__(1, weight, stiffness)
        self.frame = frame

    def evaluate(self, state: BodyState, jacobian: Matrix, target: Vector) -> None:
        """See Task.evaluate."""
        jacobian[0] = state.jacobian(self.frame)[5]
        turned = heading(state.placement(self.frame).rotation)
        target[0] = (
            -self.stiffness * turned - self.damping * (jacobian[0] @ state.velocity) - state.drift(self.frame)[5]
        )


@compiled
def heading(rotation: Matrix) -> float:
    """Where a body (3, 3) faces in rad to the left of forward: at a right angle to its left side, however it leans."""
    return float(np.arctan2(-rotation[0, 1], rotation[1, 1]))


class Facing(Piece):
    """Draw the pelvis to face where the feet point, weighed by the range of its turning as the spine is.

    By joints alone it would be cheap: hips and ankles share the turning. On the way home the joints lead.
    """

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.task = FacingTask(WEIGHT, STIFFNESS_PER_S2, scene.state.frame("pelvis"))

    def tasks(self) -> list[TimedTask]:
        """See Piece.tasks."""
        return [TimedTask(self.task, np.ones(self.scene.phases[-1].stop), aims=True)]

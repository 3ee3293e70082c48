"""Joints are drawn to the stance by their ranges: a degree of a small range costs as much as several of a large one."""

import numpy as np

from fatigue_planner.human.joint_data import degrees_of_freedom, position_limits
from fatigue_planner.motion.physiology.piece import Piece, Scene, Vector

# The range of motion whose joint has the weight of the paper's posture task.
REFERENCE_RAD = np.radians(90)
# The spine's bending sideways and turning, which are coupled and which standing people hardly use for reaching.
SPINE = ("lumbar_lateral", "lumbar_rotation", "thoracic_lateral", "thoracic_rotation")
SPINE_FACTOR = 20.0


class RangeWeights(Piece):
    """Weigh the posture task by (90 degrees / range)^2, and the spine's axes beside the sagittal one 20 times.

    So the sum of squares is one of shares of the ranges, the discomfort that predicts lifting postures best (Human
    Factors 2022, doi 10.1177/00187208221096928).
    """

    # The joints pull harder at the hand than with the paper's equal weights.
    hand_weight_factor = 5.0

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        lower, upper = position_limits()
        self.factor: Vector = (REFERENCE_RAD / (upper - lower)) ** 2
        for name in SPINE:
            self.factor[degrees_of_freedom(name)] *= SPINE_FACTOR

    def draw(self, weight: Vector, target: Vector) -> None:
        """See Piece.draw."""
        weight *= self.factor

"""The ends of a range are uncomfortable before they are reached: a zone before each pushes back."""

import numpy as np

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.joint_data import degrees_of_freedom, position_limits
from fatigue_planner.human.multibody import BASE_DOF
from fatigue_planner.motion.physiology.piece import Piece, Scene, Vector

ZONE_RAD = np.radians(8)
# People stand with nearly straight knees.
KNEE_ZONE_RAD = np.radians(3)
WEIGHT = 50.0
STIFFNESS_PER_S2 = 40.0


class EndZones(Piece):
    """In a zone before the end of its range a joint is drawn back, the harder the deeper it is inside.

    With r = depth / zone, a term of weight 50 r^2 wants the acceleration 40 depth - 2 sqrt(40) velocity, away from the
    end. No zone reaches beyond the stance's own distance to the end, so that nothing moves a worker who stands.
    """

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.lower, self.upper = position_limits()
        zone = np.full(len(self.lower), ZONE_RAD)
        below, above = zone.copy(), zone.copy()
        below[degrees_of_freedom("knee_flexion")] = KNEE_ZONE_RAD
        self.below: Vector = np.minimum(below, scene.stance_rad - self.lower)
        self.above: Vector = np.minimum(above, self.upper - scene.stance_rad)

    def draw(self, weight: Vector, target: Vector) -> None:
        """See Piece.draw."""
        state = self.scene.state
        _draw_back(
            state.configuration[7:], state.velocity[BASE_DOF:], self.lower, self.upper, self.below, self.above,
            weight, target,
        )  # fmt: skip


@compiled
def _draw_back(
    angles: Vector, speeds: Vector, lower: Vector, upper: Vector, below: Vector, above: Vector,
    weight: Vector, target: Vector,
) -> None:  # fmt: skip
    """Join the terms of the zones to those that already draw the joints: weights add up, targets are averaged."""
    for i in range(len(angles)):
        near_lower, near_upper = below[i] - (angles[i] - lower[i]), above[i] - (upper[i] - angles[i])
        if near_lower > 0:
            share, back = near_lower / below[i], near_lower
        elif near_upper > 0:
            share, back = near_upper / above[i], -near_upper
        else:
            continue
        own = WEIGHT * share**2
        wanted = STIFFNESS_PER_S2 * back - 2 * np.sqrt(STIFFNESS_PER_S2) * speeds[i]
        target[i] = (weight[i] * target[i] + own * wanted) / (weight[i] + own)
        weight[i] += own

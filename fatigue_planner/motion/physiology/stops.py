"""A locked knee and a fully bent spine rest on bone and ligament."""

import numpy as np

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.joint_data import degrees_of_freedom, position_limits
from fatigue_planner.motion.physiology.piece import Bearer, Vector

# How near to its end a joint rests on its stop.
REACH_RAD = np.radians(1)
# The stops of the skeleton, and the side on which they are: where the joint's range begins, or where it ends.
AT_LOWER, AT_UPPER = ("knee_flexion", "elbow_flexion"), ("lumbar_flexion", "thoracic_flexion")


class Stops(Bearer):
    """Within a degree of its end a stop bears what muscles would have to exert inward; muscles bear the rest.

    It bears nothing a degree before the end and everything at the end, growing as 3 x^2 - 2 x^3 between, so that no
    torque steps. It only ever pushes inward.
    """

    def __init__(self, person: Anthropometry) -> None:
        super().__init__(person)
        lower, upper = position_limits()
        self.ends = np.where(_side(AT_UPPER), upper, lower)
        self.inward = np.where(_side(AT_LOWER), 1.0, np.where(_side(AT_UPPER), -1.0, 0.0))

    def relieve(self, angles: Vector, torque_nm: Vector, moments: Vector) -> None:
        """See Bearer.relieve."""
        _add_reactions(angles, torque_nm, self.ends, self.inward, moments)


def _side(names: tuple[str, ...]) -> Vector:
    """Which degrees of freedom (39,) have one of these names."""
    found = np.zeros(len(position_limits()[0]), dtype=bool)
    found[[index for name in names for index in degrees_of_freedom(name)]] = True
    return found


@compiled
def _add_reactions(angles: Vector, torque_nm: Vector, ends: Vector, inward: Vector, moments: Vector) -> None:
    for i in range(len(angles)):
        distance = inward[i] * (angles[i] - ends[i])
        if inward[i] != 0 and distance < REACH_RAD:
            near = min(1.0, 1 - distance / REACH_RAD)
            muscle_nm = max(0.0, inward[i] * (torque_nm[i] - moments[i]))
            moments[i] += inward[i] * near**2 * (3 - 2 * near) * muscle_nm

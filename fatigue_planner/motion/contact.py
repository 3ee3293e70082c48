"""A flat sole on the ground: it stays put, presses, and does not slip."""

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.motion.body_state import BodyState

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

WRENCH = 6
CONE_ROWS = 16


def wrench_cone(half_length_m: float, half_breadth_m: float, friction_coefficient: float) -> Matrix:
    """Rows G (16, 6) with G w <= 0 for the wrench w = (force, moment) at the centre of a sole.

    The closed form of Caron, Pham & Nakamura (ICRA 2015, Eq. 17-19): w is admissible if and only if
    it is the sum of forces at the four corners, each pressing and inside a friction pyramid. The
    pyramid is the one inscribed in the Coulomb cone (mu / sqrt 2), so the cone itself holds too; the
    moment rows keep the centre of pressure inside the sole and bound the yaw torque.
    """
    mu, X, Y = friction_coefficient / np.sqrt(2), half_length_m, half_breadth_m
    rows = [[a, b, -mu, 0, 0, 0] for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    rows += [[0, 0, -Y, s, 0, 0] for s in (1, -1)] + [[0, 0, -X, 0, s, 0] for s in (1, -1)]
    # |Y fx - mu mx| + |X fy - mu my| - mu (X + Y) fz <= mz <= mu (X + Y) fz - |Y fx + mu mx| - |X fy + mu my|
    for a in (1, -1):
        for b in (1, -1):
            rows.append([a * Y, b * X, -mu * (X + Y), -a * mu, -b * mu, -1])
            rows.append([a * Y, b * X, -mu * (X + Y), a * mu, b * mu, 1])
    return np.array(rows, dtype=float)


class SoleContact:
    """A sole that keeps the pose it has at the start."""

    def __init__(self, state: BodyState, frame: int, stiffness: float) -> None:
        self.frame = frame
        self.stiffness = stiffness
        self.damping = 2 * np.sqrt(stiffness)
        self.home: pin.SE3 = state.placement(frame).copy()

    def displacement(self, state: BodyState) -> Vector:
        """How far the sole is from its initial pose: (6,) m and rad, in the sole's axes."""
        return np.asarray(pin.log6(self.home.actInv(state.placement(self.frame))).vector)

    def required_acceleration(self, state: BodyState, jacobian: Matrix) -> Vector:
        """Right-hand side of J a = ... (6,) that keeps (and returns) the sole in place; J (6, 45) in its axes."""
        moved, drift = self.displacement(state), state.local_drift(self.frame)
        required: Vector = _required(moved, jacobian, state.velocity, drift, self.stiffness, self.damping)
        return required


@compiled
def _required(
    displacement: Vector, jacobian: Matrix, velocity: Vector, drift: Vector, stiffness: float, damping: float
) -> Vector:
    """-K_p e - K_d J v - drift."""
    return -stiffness * displacement - damping * (jacobian @ velocity) - drift

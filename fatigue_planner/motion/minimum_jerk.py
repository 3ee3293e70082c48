"""Minimum-jerk motion of a pose (Flash & Hogan 1985), with its velocity and acceleration."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Pose:
    """A position (3,) m and a rotation matrix (3, 3) in the world."""

    position_m: Vector
    rotation: Matrix


@dataclass(frozen=True)
class MovingPose:
    """A pose with its velocity and acceleration, each (6,): linear, then angular part, world axes."""

    pose: Pose
    velocity: Vector
    acceleration: Vector

    @classmethod
    def at_rest(cls, pose: Pose) -> Self:
        """A pose that does not move."""
        return cls(pose, np.zeros(6), np.zeros(6))


def minimum_jerk(fraction: float) -> tuple[float, float, float]:
    """Path share s and its first and second derivatives after a fraction of the duration.

    s(x) = 10 x^3 - 15 x^4 + 6 x^5 for 0 <= x <= 1, held outside (derivatives with respect to x).
    """
    x = min(max(fraction, 0.0), 1.0)
    return (
        x**3 * (10 - 15 * x + 6 * x**2),
        30 * x**2 * (1 - x) ** 2,
        60 * x * (1 - x) * (1 - 2 * x),
    )


@dataclass(frozen=True)
class Reach:
    """A minimum-jerk motion between two poses along a straight line and the shortest rotation."""

    start: Pose
    end: Pose
    duration_s: float

    def at(self, time_s: float) -> MovingPose:
        """The reference at a time since the start of the motion."""
        share, rate, curvature = minimum_jerk(time_s / self.duration_s)
        rate /= self.duration_s
        curvature /= self.duration_s**2
        path = self.end.position_m - self.start.position_m
        turn = pin.log3(self.start.rotation.T @ self.end.rotation)
        whole = np.concatenate([path, self.start.rotation @ turn])
        pose = Pose(self.start.position_m + share * path, self.start.rotation @ pin.exp3(share * turn))
        return MovingPose(pose, rate * whole, curvature * whole)

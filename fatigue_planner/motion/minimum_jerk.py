"""Minimum-jerk motion of a pose (Flash & Hogan 1985), with its velocity and acceleration."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
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
class Trajectory:
    """A pose over T instants: position (T, 3), rotation (T, 3, 3); velocity and acceleration (T, 6), each linear,
    then angular part, world axes.
    """

    position_m: Matrix
    rotation: Matrix
    velocity: Matrix
    acceleration: Matrix

    @classmethod
    def at_rest(cls, pose: Pose) -> Self:
        """A pose that does not move, for one instant."""
        return cls(pose.position_m[None], pose.rotation[None], np.zeros((1, 6)), np.zeros((1, 6)))

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Trajectories one after the other."""
        return cls(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)))


def minimum_jerk(fraction: Vector) -> tuple[Vector, Vector, Vector]:
    """Path fraction s (T,) and its first and second derivatives after fractions (T,) of the duration.

    s(x) = 10 x^3 - 15 x^4 + 6 x^5 for 0 <= x <= 1, held outside (derivatives with respect to x).
    """
    x = np.clip(fraction, 0.0, 1.0)
    return (
        x**3 * (10 - 15 * x + 6 * x**2),
        30 * x**2 * (1 - x) ** 2,
        60 * x * (1 - x) * (1 - 2 * x),
    )


@dataclass(frozen=True)
class Reach:
    """A minimum-jerk motion between two poses along a straight line and the shortest rotation.

    other_way: the rotation about the same axis the other way round.
    """

    start: Pose
    end: Pose
    duration_s: float
    other_way: bool = False

    def at(self, times_s: Vector) -> Trajectory:
        """The reference at times (T,) since the start of the motion; held at its end after it.

        Rodrigues' formula turns the start by s times the angle about the axis of the whole turn.
        """
        share, rate, curvature = minimum_jerk(times_s / self.duration_s)
        rate, curvature = rate / self.duration_s, curvature / self.duration_s**2
        path = self.end.position_m - self.start.position_m
        turn = pin.log3(self.end.rotation @ self.start.rotation.T)
        angle = float(np.linalg.norm(turn))
        if self.other_way and angle > 0:
            turn = turn * (angle - 2 * np.pi) / angle
            angle = 2 * np.pi - angle
        cross = pin.skew(turn / angle) if angle > 0 else np.zeros((3, 3))
        turned = (
            np.eye(3)
            + np.sin(share * angle)[:, None, None] * cross
            + (1 - np.cos(share * angle))[:, None, None] * (cross @ cross)
        )
        whole = np.concatenate([path, turn])
        return Trajectory(
            self.start.position_m + share[:, None] * path,
            turned @ self.start.rotation,
            rate[:, None] * whole,
            curvature[:, None] * whole,
        )

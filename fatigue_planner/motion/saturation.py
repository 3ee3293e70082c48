"""Joints whose torque is at its limit: the mark of a worker who is not strong enough."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

AT_LIMIT = 0.999  # of the maximum torque


class Saturation(NamedTuple):
    """The joint that is at its limit for the largest share of the ticks (empty if none is), that share, and the first
    such tick.
    """

    joint: str
    share: float
    first_tick: int


def saturation(torque_nm: Matrix, positive_nm: Vector, negative_nm: Vector) -> Saturation:
    """Saturation of torques (T, 39) with maxima (39,) in both directions; where there is none, the share is 0."""
    at_limit = (torque_nm >= AT_LIMIT * positive_nm) | (torque_nm <= -AT_LIMIT * negative_nm)
    share = at_limit.mean(axis=0)
    joint = int(share.argmax())
    name = DEGREES_OF_FREEDOM[joint] if share[joint] > 0 else ""
    return Saturation(name, float(share[joint]), int(at_limit[:, joint].argmax()))

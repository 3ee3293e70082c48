"""A hand turns to its work the way round that is easier for the body, not always the shortest."""

import itertools
from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from fatigue_planner.motion.minimum_jerk import Trajectory
from fatigue_planner.motion.physiology.piece import Matrix, Piece, Vector
from fatigue_planner.motion.settings import Side

# A hand that is turned by more may as well turn the other way round, at most twice as far.
EITHER_WAY_RAD = np.radians(120)


class HandTurn(Piece):
    """Try both ways round where a hand is turned far, and keep the one that takes less effort.

    A ball joint is free to turn either way; the shoulder's range is not symmetric: an arm is raised forward by 200
    degrees, not backward by 160.
    """

    turns_either_way = True


def ways_round(paths: dict[Side, Trajectory], work_start: int) -> Iterator[frozenset[Side]]:
    """The hands that turn the longer way, for every way of turning worth a try; first none."""
    far = [
        side
        for side, path in paths.items()
        if np.linalg.norm(pin.log3(path.rotation[work_start] @ path.rotation[0].T)) > EITHER_WAY_RAD
    ]
    for count in range(len(far) + 1):
        yield from map(frozenset, itertools.combinations(far, count))


def effort(torque_nm: Matrix, positive_nm: Vector, negative_nm: Vector) -> float:
    """The mean over a cycle of the sum of squared loads, as shares of the strength."""
    share = np.maximum(torque_nm / positive_nm, -torque_nm / negative_nm)
    return float(np.square(share).sum(axis=1).mean())

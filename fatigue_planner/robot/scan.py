"""Where else a robot's base could stand: how much it reaches from other distances and heights."""

import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

from fatigue_planner.robot.reach import Cell
from fatigue_planner.robot.settings import RobotBase

# Where the base is tried, in m: an arm's length and more before the worker, from the ground to a high table.
FORWARD_M = (0.7, 0.9, 1.1, 1.3)
HEIGHTS_M = (0.0, 0.25, 0.5, 0.75, 1.0)


class Standpoint(NamedTuple):
    """How much the robot reaches with its base at another place."""

    x_m: float
    height_m: float
    reached: int


def scanned(
    cell: Cell, reached: Callable[[Cell], int], forward_m: Sequence[float], heights_m: Sequence[float]
) -> list[Standpoint]:
    """How much is reached from every place of the base, by what `reached` says of it; y and yaw stay."""
    found = []
    for x, height in itertools.product(forward_m, heights_m):
        base: RobotBase = cell.settings.base_m.model_copy(update={"x": float(x), "z": float(height)})
        found.append(Standpoint(float(x), float(height), reached(cell.at(base))))
    return found

"""What is in the way of any movement: the limit of a program without solution that would have to be relaxed least."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.motion.contact import CONE_ROWS
from fatigue_planner.motion.quadratic_program import QuadraticProgram, smallest_slack

Vector = NDArray[np.float64]
Indices = NDArray[np.intp]


class LimitKind(Enum):
    """The limits that may leave no movement."""

    JOINT = "joint range"
    TORQUE = "torque"
    CONTACT = "contact"


class Obstacle(NamedTuple):
    """The limit in the way of any movement: its kind, its location, by how much in words, and relative to its scale."""

    kind: LimitKind
    location: str
    amount: str
    share: float


@dataclass(frozen=True)
class Limits:
    """The limits of one kind: variables (b,) and rows (r,) of the program, and a scale (b + r,) for each of them."""

    bounds: Indices
    rows: Indices
    scale: Vector

    def slack(self, program: QuadraticProgram) -> Vector | None:
        """By how much, at least, they have to be relaxed for a solution if no others may be; None if none helps."""
        return smallest_slack(program, self.bounds, self.rows, self.scale)


def least_obstacle(
    program: QuadraticProgram, limits: Mapping[LimitKind, Limits], lowest_nm: Vector, highest_nm: Vector
) -> Obstacle | None:
    """The limit that would have to be relaxed least, relative to its scale, of all kinds; None if no kind helps."""
    obstacles = []
    for kind, own in limits.items():
        slack = own.slack(program)
        if slack is None:
            continue
        share = np.abs(slack) / own.scale
        worst = int(share.argmax())
        excess = abs(slack[worst])
        match kind:
            case LimitKind.JOINT:
                location, amount = DEGREES_OF_FREEDOM[worst], f"{excess:.0f} rad/s^2 beyond what it may accelerate"
            case LimitKind.TORQUE:
                limit = (highest_nm if slack[worst] > 0 else -lowest_nm)[worst]
                location = DEGREES_OF_FREEDOM[worst]
                amount = f"{excess:.1f} N.m more than the {limit:.1f} N.m allowed"
            case LimitKind.CONTACT:
                location, amount = f"the {SIDES[worst // CONE_ROWS]} foot", "it would lift, tip or slip"
        obstacles.append(Obstacle(kind, location, amount, float(share[worst])))
    return min(obstacles, key=lambda obstacle: obstacle.share, default=None)

"""How near a robot's arm comes to a worker's body while the worker works; compiled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.capsules import Capsules, capsules_of
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.motion.settings import Side
from fatigue_planner.robot.kinematics import axes_apart

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]


class Nearest(NamedTuple):
    """The least distance in m of arm and body (negative: they overlap), the part of the body, and the tick."""

    distance_m: float
    part: str
    tick: int


class Body:
    """The parts of a worker's body that a robot should stay away from: all but the hands that hold what it presents."""

    def __init__(self, person: Anthropometry, working: frozenset[Side]) -> None:
        self._tree, capsules = tree_of(person), capsules_of(person)
        own = [index for index, body in enumerate(BODIES) if body not in {f"{side}_hand" for side in working}]
        self._parts = [BODIES[index] for index in own]
        self._own = np.array(own)
        self._capsules: Capsules = capsules
        self.radius_m: Vector = capsules.radius_m[own]

    def ends_m(self, configuration: Vector) -> Vector:
        """The ends (n, k, 2, 3) m of the parts in the world at configurations (n, 46), as in `Human`."""
        return np.ascontiguousarray(self._capsules.world_ends(poses_of(self._tree, configuration))[:, self._own])

    def nearest(self, configuration: Vector, arm_ends_m: Vector, arm_radius_m: Vector) -> Nearest:
        """The nearest that an arm (c, 2, 3) and (c,) m, which stands still, comes to the body over a motion (n, 46)."""
        distance, part, tick = _nearest(self.ends_m(configuration), self.radius_m, arm_ends_m, arm_radius_m)
        return Nearest(float(distance), self._parts[part], int(tick))


@compiled
def _nearest(ends: Vector, radius: Vector, arm_ends: Vector, arm_radius: Vector) -> tuple[float, int, int]:
    """The least distance of capsules (n, k, 2, 3) from others (c, 2, 3); which of the k, and in which of the n."""
    least, part, tick = np.inf, 0, 0
    for row in range(ends.shape[0]):
        for i in range(radius.size):
            for j in range(arm_radius.size):
                apart = axes_apart(ends[row, i], arm_ends[j]) - radius[i] - arm_radius[j]
                if apart < least:
                    least, part, tick = apart, i, row
    return least, part, tick

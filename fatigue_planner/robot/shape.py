"""What is seen of a robot that presents something: its arm, what it stands on, and how it holds the object."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.robot.settings import PEDESTAL_RADIUS_M

Vector = NDArray[np.float64]

# What reaches from the flange to the object is drawn so thick; of the gripper nothing is known but its length.
HOLDER_RADIUS_M = 0.025


@dataclass(frozen=True)
class RobotShape:
    """A robot in its place as capsules in the world: ends (n, 2, 3) and radii (n,) in m.

    arm          of every waypoint (w, c, 2, 3), with `arm_radius` (c,)
    holder       of every waypoint (w, 2, 3), from the flange to the fist
    pedestal     (k, 2, 3), k = 1, or 0 where the base is on the ground
    times_s      when the waypoints are (w,), in s of the work; between them the arm's way is not planned
    """

    arm: Vector
    arm_radius: Vector
    holder: Vector
    pedestal: Vector
    times_s: Vector

    def waypoint(self, work_time_s: float) -> int:
        """The waypoint that is nearest to a time of the work."""
        return int(np.abs(self.times_s - work_time_s).argmin())

    def parts(self, waypoint: int) -> tuple[Vector, Vector]:
        """All capsules (n, 2, 3) and their radii (n,): pedestal, arm and holder."""
        ends = np.concatenate([self.pedestal, self.arm[waypoint], self.holder[waypoint][None]])
        radii = [*np.full(len(self.pedestal), PEDESTAL_RADIUS_M), *self.arm_radius, HOLDER_RADIUS_M]
        return ends, np.array(radii)

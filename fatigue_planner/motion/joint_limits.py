"""Joint limits as bounds on the joint accelerations of one tick.

Position, velocity and viability bounds of Del Prete, "Joint position and velocity bounds in
discrete-time acceleration/torque control of robot manipulators", IEEE RA-L 3(1), 2018. As usual the
bounds look ahead over a window of two ticks, which keeps them from chattering.
"""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled

Vector = NDArray[np.float64]


@compiled
def acceleration_bounds(
    position: Vector,
    velocity: Vector,
    lower: Vector,
    upper: Vector,
    velocity_limit: float,
    acceleration_limit: float,
    window_s: float,
    lowest: Vector,
    highest: Vector,
) -> None:
    """Write the lowest and highest joint accelerations (each (n,), rad/s^2) that keep the limits reachable.

    `position` and `velocity` (n,) are the joints' state, `lower` and `upper` (n,) their range,
    `window_s` the look-ahead. Where the bounds contradict each other the lower one gives way.
    """
    for i in range(len(position)):
        highest[i] = _upper_bound(upper[i] - position[i], velocity[i], velocity_limit, acceleration_limit, window_s)
        # a lower limit is an upper one seen in the mirror
        mirrored = _upper_bound(position[i] - lower[i], -velocity[i], velocity_limit, acceleration_limit, window_s)
        lowest[i] = min(-mirrored, highest[i])


@compiled
def _upper_bound(room: float, velocity: float, velocity_limit: float, acceleration_limit: float, dt: float) -> float:
    """Highest acceleration with `room` left to the upper limit."""
    stop_now = -velocity / dt
    ahead = room - dt * velocity
    # position: either still inside after dt, or braking so that the joint stops at the limit
    by_position = ahead * 2 / dt**2
    if velocity > 0 and by_position <= stop_now:
        by_position = min(stop_now, -(velocity**2) / (2 * room)) if room > 0 else stop_now
    # viability: after dt the joint can still stop before the limit with the acceleration limit
    b = 2 * dt * velocity + acceleration_limit * dt**2
    discriminant = b**2 - 4 * dt**2 * (velocity**2 - 2 * acceleration_limit * ahead)
    by_viability = stop_now
    if discriminant >= 0:
        by_viability = max(stop_now, (np.sqrt(discriminant) - b) / (2 * dt**2))
    by_speed = min((velocity_limit - velocity) / dt, acceleration_limit)
    return min(by_position, by_viability, by_speed)

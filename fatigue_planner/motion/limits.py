"""Joint limits as bounds on the joint accelerations of one tick.

Position, velocity and viability bounds of Del Prete, "Joint position and velocity bounds in
discrete-time acceleration/torque control of robot manipulators", IEEE RA-L 3(1), 2018. As usual the
bounds look ahead over a window of two ticks, which keeps them from chattering.
"""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

_TINY = 1e-300  # keeps from dividing by a room of zero, where another bound is taken


def acceleration_bounds(
    position: Vector,
    velocity: Vector,
    lower: Vector,
    upper: Vector,
    velocity_limit: float,
    acceleration_limit: float,
    window_s: float,
) -> tuple[Vector, Vector]:
    """Lowest and highest joint accelerations (each (n,), rad/s^2) that keep the limits reachable.

    `position` and `velocity` (n,) are the joints' state, `lower` and `upper` (n,) their range,
    `window_s` the look-ahead. Where the bounds contradict each other the lower one gives way.
    """
    n = position.size
    # a lower limit is an upper one seen in the mirror: both sides in one go
    outward = np.concatenate([velocity, -velocity])
    room = np.concatenate([upper - position, position - lower])
    bounds = _upper_bound(room, outward, velocity_limit, acceleration_limit, window_s)
    highest = bounds[:n]
    return np.minimum(-bounds[n:], highest), highest


def _upper_bound(room: Vector, velocity: Vector, velocity_limit: float, acceleration_limit: float, dt: float) -> Vector:
    """Highest acceleration (m,) with `room` left to the upper limit."""
    stop_now = velocity * (-1 / dt)
    ahead = room - dt * velocity
    # position: either still inside after dt, or braking so that the joint stops at the limit
    inside_after = ahead * (2 / dt**2)
    stop_at_limit = np.where(room > 0, velocity**2 / np.minimum(-2 * room, -_TINY), stop_now)
    braking = (velocity > 0) & (inside_after <= stop_now)
    by_position = np.where(braking, np.minimum(stop_now, stop_at_limit), inside_after)
    # viability: after dt the joint can still stop before the limit with the acceleration limit
    b = (2 * dt) * velocity + acceleration_limit * dt**2
    discriminant = b**2 - (4 * dt**2) * (velocity**2 - 2 * acceleration_limit * ahead)
    root = (np.sqrt(np.maximum(discriminant, 0)) - b) / (2 * dt**2)
    by_viability = np.where(discriminant >= 0, np.maximum(stop_now, root), stop_now)
    by_speed = np.minimum((velocity_limit - velocity) / dt, acceleration_limit)
    return np.minimum(np.minimum(by_position, by_viability), by_speed)

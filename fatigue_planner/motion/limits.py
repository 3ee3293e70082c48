"""Joint limits as bounds on the joint accelerations of one tick.

Position, velocity and viability bounds of Del Prete, "Joint position and velocity bounds in
discrete-time acceleration/torque control of robot manipulators", IEEE RA-L 3(1), 2018. As usual the
bounds look ahead over a window of two ticks, which keeps them from chattering.
"""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


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
    highest = _upper_bound(position, velocity, upper, velocity_limit, acceleration_limit, window_s)
    lowest = -_upper_bound(-position, -velocity, -lower, velocity_limit, acceleration_limit, window_s)
    return np.minimum(lowest, highest), highest


def _upper_bound(
    position: Vector, velocity: Vector, upper: Vector, velocity_limit: float, acceleration_limit: float, dt: float
) -> Vector:
    room = upper - position
    stop_now = -velocity / dt
    # position: either still inside after dt, or braking so that the joint stops at the limit
    inside_after = 2 * (room - dt * velocity) / dt**2
    with np.errstate(divide="ignore", invalid="ignore"):
        stop_at_limit = np.where(room > 0, -(velocity**2) / (2 * room), stop_now)
    moving_out = velocity > 0
    by_position = np.where(moving_out & (inside_after <= stop_now), np.minimum(stop_now, stop_at_limit), inside_after)
    # viability: after dt the joint can still stop before the limit with the acceleration limit
    b = 2 * dt * velocity + acceleration_limit * dt**2
    c = velocity**2 - 2 * acceleration_limit * (room - dt * velocity)
    discriminant = b**2 - 4 * dt**2 * c
    root = (-b + np.sqrt(np.maximum(discriminant, 0))) / (2 * dt**2)
    by_viability = np.where(discriminant >= 0, np.maximum(stop_now, root), stop_now)
    by_velocity = (velocity_limit - velocity) / dt
    return np.minimum(np.minimum(by_position, by_viability), np.minimum(by_velocity, acceleration_limit))

"""The inverse kinematics of an arm of Universal Robots once more, by another method from random starts.

Nothing is shared with the program: the arm is Denavit and Hartenberg's published parameters instead of frames, a
direction is missed by a difference of vectors instead of an angle, and the damping of Levenberg and Marquardt's method
follows the gain ratio (Nielsen 1999) instead of the error.
"""

import numba
import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

# Denavit and Hartenberg's a, d and alpha, in m and rad, as Universal Robots publishes them.
PUBLISHED = {
    "ur3e": ((0, -0.24355, -0.2132, 0, 0, 0), (0.15185, 0, 0, 0.13105, 0.08535, 0.0921)),
    "ur5e": ((0, -0.425, -0.3922, 0, 0, 0), (0.1625, 0, 0, 0.1333, 0.0997, 0.0996)),
    "ur10e": ((0, -0.6127, -0.57155, 0, 0, 0), (0.1807, 0, 0, 0.17415, 0.11985, 0.11655)),
}
ALPHA = (np.pi / 2, 0, 0, np.pi / 2, -np.pi / 2, 0)
# Found is what comes this near, in m and by the length of the difference of unit vectors.
NEAR_M, NEAR = 1e-6, 1e-6
STEPS, DIRECTION_M = 200, 0.3
# A search that still misses, and by no more than this share less with a step that helps, has found the least it can.
STUCK = 1e-5


def solutions(name: str, base: Vector, target: Vector, starts: Vector) -> Vector:
    """Joint angles (k, 6) rad, within half a turn, at which the flange is at `target` (4, 4), turned as it likes.

    From starts (s, 6) rad; base (4, 4) is the frame of the arm's base in the world. Every joint of these arms can turn
    by half a turn either way, so limits are never in the way.
    """
    (a, d), seen = PUBLISHED[name], np.linalg.inv(base) @ target
    parameters = np.array([a, d, ALPHA], dtype=float)
    ends = [_sought(parameters, seen[:3, 3].copy(), seen[:3, 2].copy(), start.copy()) for start in starts]
    found = [angles for angles, is_there in ends if is_there]
    return (np.array(found).reshape(-1, 6) + np.pi) % (2 * np.pi) - np.pi


@numba.njit(nogil=True)
def _missing(parameters: Vector, point: Vector, direction: Vector, angles: Vector, off: Vector, slope: Vector) -> float:
    """Write what is missing (6,) and how it changes with every joint (6, 6); the sum of its squares."""
    axes, origins = np.empty((7, 3)), np.empty((7, 3))
    turned, at = np.eye(3), np.zeros(3)
    for joint in range(6):
        axes[joint], origins[joint] = turned[:, 2], at
        a, d, alpha = parameters[:, joint]
        c, s, ca, sa = np.cos(angles[joint]), np.sin(angles[joint]), np.cos(alpha), np.sin(alpha)
        at = at + turned @ np.array([a * c, a * s, d])
        turned = turned @ np.array([[c, -s * ca, s * sa], [s, c * ca, -c * sa], [0.0, sa, ca]])
    pointing = turned[:, 2].copy()
    off[:3], off[3:] = at - point, DIRECTION_M * (pointing - direction)
    for joint in range(6):
        slope[:3, joint] = np.cross(axes[joint], at - origins[joint])
        slope[3:, joint] = DIRECTION_M * np.cross(axes[joint], pointing)
    return (off * off).sum()


@numba.njit(nogil=True)
def _sought(parameters: Vector, point: Vector, direction: Vector, angles: Vector) -> tuple[Vector, bool]:
    """Where the search from these angles (6,) ends, and whether the flange is there."""
    off, slope, new_off, new_slope = np.empty(6), np.empty((6, 6)), np.empty(6), np.empty((6, 6))
    cost = _missing(parameters, point, direction, angles, off, slope)
    damping, factor = 1e-3 * np.diag(slope.T @ slope).max(), 2.0
    for _ in range(STEPS):
        if np.sqrt((off[:3] ** 2).sum()) < NEAR_M and np.sqrt((off[3:] ** 2).sum()) < DIRECTION_M * NEAR:
            return angles, True
        gradient = slope.T @ off
        step = -np.linalg.solve(slope.T @ slope + damping * np.eye(6), gradient)
        if (step * step).sum() < 1e-20:
            break
        new_cost = _missing(parameters, point, direction, angles + step, new_off, new_slope)
        gain = (cost - new_cost) / (step * (damping * step - gradient)).sum()
        if gain > 0:
            if cost - new_cost < STUCK * cost:
                break
            angles, cost = angles + step, new_cost
            off[:], slope[:] = new_off, new_slope
            damping, factor = damping * max(1 / 3, 1 - (2 * gain - 1) ** 3), 2.0
        else:
            damping, factor = damping * factor, 2 * factor
    return angles, False

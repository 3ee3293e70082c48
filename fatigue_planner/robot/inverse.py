"""Angles of the joints at which the flange is where it shall be: inverse kinematics from many starts, compiled."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.robot.arm import Chain
from fatigue_planner.robot.kinematics import (
    axes_apart,
    capsule_ends,
    clearance_between,
    frames_of,
    jacobian_of,
    own_clearance,
)

Vector = NDArray[np.float64]

# Found is what comes this near, in m and rad: a hundredth of what a solution has to hold (1 mm, 0.1 degrees).
NEAR_M, NEAR_RAD = 1e-5, 1.7e-5
# In the sum of squared errors, a radian counts as much as so many metres: about a forearm's length.
RADIAN_M = 0.3
MAX_STEPS = 60
# A start is given up when its error has not fallen by a hundredth within so many steps.
PATIENCE = 10
# A joint with this range in rad has every direction within its limits.
WHOLE_TURN = 2 * np.pi - 1e-9
# What a posture of the arm touches: only what is solid about it, or itself or the ground, whatever else there is.
NOTHING, SOLID, ITSELF = 0, 1, 2


class Freedom(IntEnum):
    """What of the flange's orientation is left free."""

    NONE = 0
    ROLL = 1  # it points along an axis and may turn about it
    ALL = 2


class Surroundings(NamedTuple):
    """What the arm may not touch, and what it should stay away from: capsules in the world, (k, 2, 3) and (k,) m."""

    solid_ends: Vector
    solid_radius: Vector
    worker_ends: Vector
    worker_radius: Vector


class Solution(NamedTuple):
    """The best of the solutions from all starts.

    `free`, `on_solid` and `on_itself`: how many starts ended in a solution that touches nothing, SOLID or ITSELF.
    `bound` (s,): whether a limit of a joint stopped the search from a start, so that without limits it would have gone
    another way. `angles` (n,) rad and its clearance to the worker in m (inf without one) and manipulability
    sqrt(det J J^T) are those of the free one that is farthest from the worker, or of the easiest to move; without any,
    of one that touches something, or of the start that came nearest, by `missed_m` and `missed_rad`; its clearance is
    -inf.
    """

    free: int
    on_solid: int
    on_itself: int
    bound: NDArray[np.bool_]
    angles: Vector
    clearance_m: float
    manipulability: float
    missed_m: float
    missed_rad: float

    @property
    def found(self) -> bool:
        """Whether the flange gets there, whatever the arm touches."""
        return self.free + self.on_solid + self.on_itself > 0


@compiled
def solve(
    chain: Chain, base: Vector, target: Vector, freedom: int, surroundings: Surroundings, starts: Vector, first: bool
) -> Solution:
    """The best of what is found from `starts` (s, n) rad for the flange at `target` (4, 4) in the world.

    `first`: to stop at the first solution, whatever it touches.
    """
    count = starts.shape[1]
    frames, jacobian = np.empty((count + 2, 4, 4)), np.empty((6, count))
    normal, step = np.empty((count, count)), np.empty(count)
    free, on_solid, on_itself, clearance, manipulability = 0, 0, 0, -np.inf, -1.0
    bound = np.zeros(starts.shape[0], dtype=np.bool_)
    best, missed, missed_m, missed_rad = starts[0].copy(), np.inf, np.inf, np.inf
    for start in range(starts.shape[0]):
        if first and free + on_solid + on_itself > 0:
            break
        angles = starts[start].copy()
        off_m, off_rad, bound[start] = _approach(chain, base, target, freedom, angles, frames, jacobian, normal, step)
        if off_m > NEAR_M or off_rad > NEAR_RAD:
            if free == 0 and off_m + RADIAN_M * off_rad < missed:
                missed, missed_m, missed_rad = off_m + RADIAN_M * off_rad, off_m, off_rad
                best[:] = angles
            continue
        _within_limits(chain, angles)
        frames_of(chain, base, angles, frames)
        ends = capsule_ends(chain, frames)
        touched = contact(chain, ends, surroundings)
        if touched != NOTHING:
            on_solid += touched == SOLID
            on_itself += touched == ITSELF
            if free == 0:
                missed, missed_m, missed_rad = 0.0, off_m, off_rad
                best[:] = angles
            continue
        free += 1
        away = np.inf
        if surroundings.worker_radius.size:
            away = clearance_between(ends, chain.radius, surroundings.worker_ends, surroundings.worker_radius).min()
        jacobian_of(frames, jacobian)
        ease = np.sqrt(max(np.linalg.det(jacobian @ jacobian.T), 0.0))
        if away > clearance or (away == clearance and ease > manipulability):
            clearance, manipulability, missed_m, missed_rad = away, ease, off_m, off_rad
            best[:] = angles
    if free == 0:
        frames_of(chain, base, best, frames)
        jacobian_of(frames, jacobian)
        manipulability = np.sqrt(max(np.linalg.det(jacobian @ jacobian.T), 0.0))
    return Solution(free, on_solid, on_itself, bound, best, clearance, manipulability, missed_m, missed_rad)


@compiled
def contact(chain: Chain, ends: Vector, surroundings: Surroundings) -> int:
    """What the arm with its capsules at `ends` (c, 2, 3) m touches: NOTHING, SOLID or ITSELF.

    The first link stands on the base, so it may touch what that stands on.
    """
    if own_clearance(chain, ends) < 0:
        return ITSELF
    touched = NOTHING
    for capsule in range(chain.link.size):
        if chain.link[capsule] < 2:
            continue
        if min(ends[capsule, 0, 2], ends[capsule, 1, 2]) < chain.radius[capsule]:
            return ITSELF
        for solid in range(surroundings.solid_radius.size):
            apart = axes_apart(ends[capsule], surroundings.solid_ends[solid])
            if apart < chain.radius[capsule] + surroundings.solid_radius[solid]:
                touched = SOLID
    return touched


@compiled
def _within_limits(chain: Chain, angles: Vector) -> None:
    """Replace each angle by the one nearest to 0 that means the same and is within the limits, if there is one."""
    for joint in range(angles.size):
        same = (angles[joint] + np.pi) % (2 * np.pi) - np.pi
        for turns in (0, 1, -1, 2, -2):
            other = same + turns * 2 * np.pi if same <= 0 else same - turns * 2 * np.pi
            if chain.lower[joint] <= other <= chain.upper[joint]:
                angles[joint] = other
                break


@compiled
def _approach(
    chain: Chain,
    base: Vector,
    target: Vector,
    freedom: int,
    angles: Vector,
    frames: Vector,
    jacobian: Vector,
    normal: Vector,
    step: Vector,
) -> tuple[float, float, bool]:
    """Move `angles` towards the target, within the limits of joints that cannot turn once; the others go as they like.

    Returns what is missing at the end, in m and rad, and whether a limit was in the way. Levenberg and Marquardt's
    method with a damping that falls with the error (Sugihara 2011, IEEE T-RO 27:984); normal (n, n) and step (n,) are
    room to work in.
    """
    count = angles.size
    error = np.empty(6)
    least, since, off_m, off_rad, bound = np.inf, 0, np.inf, np.inf, False
    for _ in range(MAX_STEPS):
        frames_of(chain, base, angles, frames)
        off_m, off_rad = _error(frames[count + 1], target, freedom, error)
        if off_m <= NEAR_M and off_rad <= NEAR_RAD:
            break
        squared = 0.0
        for row in range(6):
            squared += error[row] * error[row]
        if squared > 0.99 * least:
            since += 1
            if since > PATIENCE:
                break
        else:
            least, since = squared, 0
        jacobian_of(frames, jacobian)
        _weigh(frames[count + 1], freedom, jacobian)
        for i in range(count):
            step[i] = 0.0
            for row in range(6):
                step[i] += jacobian[row, i] * error[row]
            for j in range(i + 1):
                total = 0.0
                for row in range(6):
                    total += jacobian[row, i] * jacobian[row, j]
                normal[i, j] = total
            normal[i, i] += 0.5 * squared + 1e-9
        _solve_definite(normal, step)
        for joint in range(count):
            angles[joint] += step[joint]
            if chain.upper[joint] - chain.lower[joint] < WHOLE_TURN:
                inside = min(max(angles[joint], chain.lower[joint]), chain.upper[joint])
                bound |= inside != angles[joint]
                angles[joint] = inside
    return off_m, off_rad, bound


@compiled
def _solve_definite(matrix: Vector, vector: Vector) -> None:
    """Put the solution of a positive definite system (n, n), of which the lower half is given, in place of `vector`.

    By Cholesky's method, in place: faster than a general solver by several times, for so few unknowns.
    """
    count = vector.size
    for i in range(count):
        for j in range(i):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
            matrix[i, j] /= matrix[j, j]
            vector[i] -= matrix[i, j] * vector[j]
            matrix[i, i] -= matrix[i, j] * matrix[i, j]
        matrix[i, i] = np.sqrt(max(matrix[i, i], 1e-12))
        vector[i] /= matrix[i, i]
    for i in range(count - 1, -1, -1):
        for k in range(i + 1, count):
            vector[i] -= matrix[k, i] * vector[k]
        vector[i] /= matrix[i, i]


@compiled
def _error(flange: Vector, target: Vector, freedom: int, error: Vector) -> tuple[float, float]:
    """Write what is missing (6,), angles weighted by RADIAN_M; returns the missing distance in m and angle in rad."""
    squared = 0.0
    for i in range(3):
        error[i] = target[i, 3] - flange[i, 3]
        squared += error[i] ** 2
        error[3 + i] = 0.0
    if freedom == 2:
        return np.sqrt(squared), 0.0
    sine, cosine = 0.0, 0.0
    if freedom == 1:
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            error[3 + i] = flange[j, 2] * target[k, 2] - flange[k, 2] * target[j, 2]
            cosine += flange[i, 2] * target[i, 2]
    else:  # half the difference of opposite elements of R_target R_flange^T is the axis times the sine
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            for column in range(3):
                error[3 + i] += 0.5 * (target[k, column] * flange[j, column] - target[j, column] * flange[k, column])
                cosine += 0.5 * target[i, column] * flange[i, column]
        cosine -= 0.5
    for i in range(3):
        sine += error[3 + i] ** 2
    sine = np.sqrt(sine)
    angle = np.arctan2(sine, cosine)
    for i in range(3):
        error[3 + i] *= RADIAN_M * angle / sine if sine > 1e-12 else RADIAN_M
    return np.sqrt(squared), angle


@compiled
def _weigh(flange: Vector, freedom: int, jacobian: Vector) -> None:
    """Weigh the rows of orientation, and take out of them what is left free."""
    for joint in range(jacobian.shape[1]):
        along = 0.0
        for i in range(3):
            along += flange[i, 2] * jacobian[3 + i, joint]
        for i in range(3):
            if freedom == 2:
                jacobian[3 + i, joint] = 0.0
            elif freedom == 1:
                jacobian[3 + i, joint] -= along * flange[i, 2]
            jacobian[3 + i, joint] *= RADIAN_M

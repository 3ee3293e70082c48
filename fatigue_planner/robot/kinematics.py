"""Where an arm's links are at an angle of each joint, and how its flange moves with them; compiled."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.human.capsule_distance import nearest_on_segments
from fatigue_planner.robot.arm import Chain

Vector = NDArray[np.float64]


@compiled
def frames_of(chain: Chain, base: Vector, angles: Vector, frames: Vector) -> None:
    """Write the frames (n + 2, 4, 4) at angles (n,) rad: the base, that after every joint, and the flange."""
    count = angles.size
    frames[0] = base
    for joint in range(count):
        _times(frames[joint], chain.placement[joint], frames[joint + 1])
        cosine, sine = np.cos(angles[joint]), np.sin(angles[joint])
        for row in range(3):
            x, y = frames[joint + 1, row, 0], frames[joint + 1, row, 1]
            frames[joint + 1, row, 0] = cosine * x + sine * y
            frames[joint + 1, row, 1] = cosine * y - sine * x
    _times(frames[count], chain.tip, frames[count + 1])


@compiled
def _times(one: Vector, other: Vector, product: Vector) -> None:
    """Write the product of two homogeneous matrices (4, 4)."""
    for i in range(3):
        for j in range(4):
            total = one[i, 3] if j == 3 else 0.0
            for k in range(3):
                total += one[i, k] * other[k, j]
            product[i, j] = total
    product[3, 0] = product[3, 1] = product[3, 2] = 0.0
    product[3, 3] = 1.0


@compiled
def jacobian_of(frames: Vector, jacobian: Vector) -> None:
    """Write how the flange's position (rows 0 to 2, m) and orientation (3 to 5, rad) in the world move with each joint.

    frames (n + 2, 4, 4) as of `frames_of`; jacobian (6, n).
    """
    count = jacobian.shape[1]
    for joint in range(count):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            away_j = frames[count + 1, j, 3] - frames[joint + 1, j, 3]
            away_k = frames[count + 1, k, 3] - frames[joint + 1, k, 3]
            jacobian[i, joint] = frames[joint + 1, j, 2] * away_k - frames[joint + 1, k, 2] * away_j
            jacobian[3 + i, joint] = frames[joint + 1, i, 2]


@compiled
def capsule_ends(chain: Chain, frames: Vector) -> Vector:
    """The ends (c, 2, 3) m of the arm's capsules in the world."""
    ends = np.empty(chain.ends.shape)
    for capsule in range(chain.link.size):
        frame = frames[chain.link[capsule]]
        for end in range(2):
            for i in range(3):
                ends[capsule, end, i] = frame[i, 3]
                for k in range(3):
                    ends[capsule, end, i] += frame[i, k] * chain.ends[capsule, end, k]
    return ends


@compiled
def axes_apart(one: Vector, other: Vector) -> float:
    """How far two segments (2, 3) are from each other, in m."""
    a = b = e = c = f = 0.0
    for i in range(3):
        u, v, r = one[1, i] - one[0, i], other[1, i] - other[0, i], one[0, i] - other[0, i]
        a, b, e, c, f = a + u * u, b + u * v, e + v * v, c + u * r, f + v * r
    s, t = nearest_on_segments(a, b, e, c, f)
    apart = 0.0
    for i in range(3):
        between = one[0, i] - other[0, i] + s * (one[1, i] - one[0, i]) - t * (other[1, i] - other[0, i])
        apart += between * between
    return float(np.sqrt(apart))


@compiled
def own_clearance(chain: Chain, ends: Vector) -> float:
    """How near parts of the arm come to each other that may not meet, in m; below 0 they are in each other."""
    nearest = np.inf
    for pair in range(chain.pairs.shape[0]):
        i, j = chain.pairs[pair, 0], chain.pairs[pair, 1]
        nearest = min(nearest, axes_apart(ends[i], ends[j]) - chain.radius[i] - chain.radius[j])
    return nearest


@compiled
def clearance_between(ends: Vector, radius: Vector, other_ends: Vector, other_radius: Vector) -> Vector:
    """The distances (c, d) m of the surfaces of capsules (c, 2, 3) and (d, 2, 3); below 0 they overlap."""
    found = np.empty((radius.size, other_radius.size))
    for i in range(radius.size):
        for j in range(other_radius.size):
            found[i, j] = axes_apart(ends[i], other_ends[j]) - radius[i] - other_radius[j]
    return found

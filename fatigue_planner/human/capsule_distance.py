"""How near capsules are to each other, by the nearest points of their axes."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled, inlined

Vector = NDArray[np.float64]
Indices = NDArray[np.int64]

# Two axes are taken for parallel if sin^2 of their angle is below this, an error of less than 1e-6 of the shorter one's
# length; a shorter axis than POINT (m^2) is a point.
PARALLEL = 1e-12
POINT = 1e-16


@inlined
def _clipped(value: float) -> float:
    return min(max(value, 0.0), 1.0)


@inlined
def nearest_on_segments(a: float, b: float, e: float, c: float, f: float) -> tuple[float, float]:
    """Where two segments p1 + s d1 and p2 + t d2, 0 <= s, t <= 1, are nearest: (s, t).

    With r = p1 - p2: a = d1.d1, b = d1.d2, e = d2.d2, c = d1.r, f = d2.r. For parallel segments the middle of the part
    where they run side by side. After Ericson, Real-Time Collision Detection (2005), section 5.1.9.
    """
    if a <= POINT and e <= POINT:
        return 0.0, 0.0
    if a <= POINT:
        return 0.0, _clipped(f / e)
    if e <= POINT:
        return _clipped(-c / a), 0.0
    determinant = a * e - b * b
    if determinant > PARALLEL * a * e:
        s = _clipped((b * f - c * e) / determinant)
    else:
        first, second = -f / b, (e - f) / b
        s = _clipped((_clipped(first) + _clipped(second)) / 2)
    t = (b * s + f) / e
    if t < 0:
        return _clipped(-c / a), 0.0
    if t > 1:
        return _clipped((b - c) / a), 1.0
    return s, t


@compiled
def capsule_distances(ends: Vector, radii: Vector, pairs: Indices) -> tuple[Vector, Vector, Vector, Vector]:
    """Distances of pairs of capsules and where they are nearest.

    ends (n, 2, 3) and radii (n,) in m, pairs (p, 2) indices of capsules. Returns the distance of the surfaces (p,),
    negative where the capsules overlap; the unit normal (p, 3) from the second to the first; and the nearest points of
    both axes (p, 3) each, in the frame of the ends. As the points are on the normal, the distance changes by
    normal . (velocity of the first body at its point - velocity of the second at its).
    Where the axes cross, the normal is perpendicular to both.
    """
    count = pairs.shape[0]
    distance, normal = np.empty(count), np.empty((count, 3))
    first, second = np.empty((count, 3)), np.empty((count, 3))
    for row in range(count):
        i, j = pairs[row, 0], pairs[row, 1]
        a = b = e = c = f = 0.0
        for axis in range(3):
            u, v = ends[i, 1, axis] - ends[i, 0, axis], ends[j, 1, axis] - ends[j, 0, axis]
            r = ends[i, 0, axis] - ends[j, 0, axis]
            a, b, e, c, f = a + u * u, b + u * v, e + v * v, c + u * r, f + v * r
        s, t = nearest_on_segments(a, b, e, c, f)
        apart = 0.0
        for axis in range(3):
            first[row, axis] = ends[i, 0, axis] + s * (ends[i, 1, axis] - ends[i, 0, axis])
            second[row, axis] = ends[j, 0, axis] + t * (ends[j, 1, axis] - ends[j, 0, axis])
            normal[row, axis] = first[row, axis] - second[row, axis]
            apart += normal[row, axis] ** 2
        apart = np.sqrt(apart)
        distance[row] = apart - radii[i] - radii[j]
        if apart > 0:
            for axis in range(3):
                normal[row, axis] /= apart
        else:
            normal[row] = _perpendicular(ends[i, 1] - ends[i, 0], ends[j, 1] - ends[j, 0])
    return distance, normal, first, second


@compiled
def _perpendicular(one: Vector, two: Vector) -> Vector:
    """A unit vector perpendicular to two vectors (3,), or to the longer one where they are parallel."""
    across, size_one, size_two = _cross(one, two)
    length = (across**2).sum()
    if length <= PARALLEL * size_one * size_two:
        along = one if size_one >= size_two else two
        axis = np.zeros(3)
        axis[np.argmin(np.abs(along))] = 1.0
        across = _cross(along, axis)[0] if max(size_one, size_two) > 0 else axis
        length = (across**2).sum()
    return np.asarray(across / np.sqrt(length))


@compiled
def _cross(one: Vector, two: Vector) -> tuple[Vector, float, float]:
    """The cross product of two vectors (3,), and their squared lengths."""
    across = np.empty(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        across[i] = one[j] * two[k] - one[k] * two[j]
    return across, (one**2).sum(), (two**2).sum()

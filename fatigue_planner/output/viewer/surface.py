"""A closed surface where a function is zero, by naive surface nets on a regular grid."""

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Faces = NDArray[np.int64]

_COARSE = 3  # cells between points of the grid that tells where the surface is


def surface(distance: Callable[[Vector], Vector], low: Vector, high: Vector, cell_m: float) -> tuple[Vector, Faces]:
    """Vertices (n, 3) m and triangles (m, 3), seen from outside anticlockwise, of the set distance < 0.

    `distance` takes points (n, 3); the set lies within the box from `low` to `high`, (3,) m each.
    """
    axes = [np.arange(a, b + cell_m, cell_m) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = _near_values(distance, grid, cell_m)
    vertices, number = _vertices(values, low, cell_m)
    faces = np.concatenate([_faces(values, number, axis) for axis in range(3)])
    return _pulled_to_zero(distance, vertices, cell_m), faces


def _near_values(distance: Callable[[Vector], Vector], grid: Vector, cell_m: float) -> NDArray[np.float64]:
    """The function on a grid (i, j, k, 3), exact near its zeros; elsewhere the value of a coarser grid."""
    coarse = grid[::_COARSE, ::_COARSE, ::_COARSE]
    values = distance(coarse.reshape(-1, 3)).reshape(coarse.shape[:3])
    for axis in range(3):
        nearest = np.minimum((np.arange(grid.shape[axis]) + _COARSE // 2) // _COARSE, coarse.shape[axis] - 1)
        values = np.take(values, nearest, axis=axis)
    near = np.abs(values) < 1.6 * _COARSE * cell_m
    values[near] = distance(grid[near])
    return values


def _vertices(values: NDArray[np.float64], low: Vector, cell_m: float) -> tuple[Vector, Faces]:
    """One vertex per cell the surface crosses, amid its crossings of the edges; and its number, -1 for none."""
    shape = np.array(values.shape) - 1
    total, crossings = np.zeros((*shape, 3)), np.zeros(shape)
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        for shift in product((0, 1), repeat=2):
            first, second = [slice(None)] * 3, [slice(None)] * 3
            for other, step in zip(others, shift, strict=True):
                first[other] = second[other] = slice(step, step + shape[other])
            first[axis], second[axis] = slice(0, shape[axis]), slice(1, shape[axis] + 1)
            a, b = values[tuple(first)], values[tuple(second)]
            crossed = (a < 0) != (b < 0)
            total[..., axis] += np.where(crossed, a / np.where(crossed, a - b, 1), 0)
            for other, step in zip(others, shift, strict=True):
                total[..., other] += step * crossed
            crossings += crossed
    inside = crossings > 0
    corner = np.argwhere(inside)
    vertices = low + cell_m * (corner + total[inside] / crossings[inside][:, None])
    number = np.full(tuple(shape), -1)
    number[inside] = np.arange(len(vertices))
    return vertices, number


def _faces(values: NDArray[np.float64], number: Faces, axis: int) -> Faces:
    """Two triangles around every crossed grid edge along an axis."""
    across, beyond = (axis + 1) % 3, (axis + 2) % 3
    a = np.moveaxis(values, (axis, across, beyond), (0, 1, 2)) < 0
    cells = np.moveaxis(number, (axis, across, beyond), (0, 1, 2))
    start, end = a[:-1, 1:-1, 1:-1], a[1:, 1:-1, 1:-1]
    corners = [cells[:, i : cells.shape[1] - 1 + i, j : cells.shape[2] - 1 + j] for i, j in product((0, 1), repeat=2)]
    faces = []
    for crossed, order in ((start & ~end, (0, 2, 3, 1)), (~start & end, (0, 1, 3, 2))):
        p, q, r, s = (corners[i][crossed] for i in order)
        faces += [np.column_stack([p, q, r]), np.column_stack([p, r, s])]
    return np.concatenate(faces)


def _pulled_to_zero(distance: Callable[[Vector], Vector], vertices: Vector, cell_m: float) -> Vector:
    """The vertices moved along the gradient onto the surface, by two Newton steps."""
    step = 0.1 * cell_m
    for _ in range(2):
        value = distance(vertices)
        slope = np.column_stack([(distance(vertices + step * unit) - value) / step for unit in np.eye(3)])
        steepness = np.maximum((slope**2).sum(axis=1), 0.25)
        vertices = vertices - np.clip((value / steepness)[:, None] * slope, -cell_m, cell_m)
    return vertices

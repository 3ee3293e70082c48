"""The shapes of a body, one convex hull per segment, and of capsules; for the eye only, the mechanics knows none."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.skeleton import SIDES

Vector = NDArray[np.float64]
Point = tuple[float, float, float]

# The build of which the girths below are drawn: 75 kg at 1.75 m.
_REFERENCE_KG_PER_M = 75 / 1.75
_SLENDER = ("head", "hand", "foot")  # bodies whose girth does not follow the mass
_RINGS, _PER_RING = 13, 24  # points of a sphere
_COARSE_RINGS, _COARSE_PER_RING = 9, 14  # of one that many are drawn of


@dataclass(frozen=True)
class Shape:
    """Vertices (n, 3) m in the body's frame and triangles (m, 3), seen from outside anticlockwise."""

    vertices: Vector
    faces: NDArray[np.int64]


# Shares of stature: body: the pairs of spheres its hull holds: (start, end, start radius, end radius, squeeze); the
# squeeze multiplies the radii along x, y and z. A limb is the right one; y changes its sign on the left.
_Row = tuple[Point, Point, float, float, Point]
_ROUND: Point = (1, 1, 1)
_TRUNK: dict[str, tuple[_Row, ...]] = {
    "pelvis": (
        ((0.000, -0.036, 0.008), (0.000, 0.036, 0.008), 0.050, 0.050, (1.12, 1, 1.1)),
        ((-0.028, -0.040, -0.018), (-0.028, -0.040, -0.018), 0.046, 0.046, _ROUND),
        ((-0.028, 0.040, -0.018), (-0.028, 0.040, -0.018), 0.046, 0.046, _ROUND),
    ),
    "abdomen": (((0.004, 0, 0.000), (0.002, 0, 0.090), 0.056, 0.058, (1, 1.36, 1)),),
    "thorax": (
        ((0.000, 0, 0.010), (-0.002, 0, 0.080), 0.058, 0.064, (1, 1.42, 1)),
        ((0.030, -0.040, 0.078), (0.030, -0.040, 0.078), 0.038, 0.038, (1, 1.2, 1)),
        ((0.030, 0.040, 0.078), (0.030, 0.040, 0.078), 0.038, 0.038, (1, 1.2, 1)),
        ((-0.012, -0.020, 0.132), (-0.004, -0.086, 0.118), 0.030, 0.032, _ROUND),
        ((-0.012, 0.020, 0.132), (-0.004, 0.086, 0.118), 0.030, 0.032, _ROUND),
    ),
    "neck": (((-0.008, 0, -0.012), (0.004, 0, 0.062), 0.034, 0.031, _ROUND),),
    "head": (
        ((0.002, 0, 0.066), (0.012, 0, 0.072), 0.046, 0.046, (1.16, 0.95, 1.22)),
        ((0.022, 0, 0.045), (0.040, 0, 0.014), 0.034, 0.018, (1, 0.95, 1)),
        ((0.058, 0, 0.052), (0.067, 0, 0.034), 0.006, 0.010, _ROUND),
        ((0.002, -0.046, 0.048), (0.004, -0.045, 0.032), 0.011, 0.007, (1, 0.5, 1)),
        ((0.002, 0.046, 0.048), (0.004, 0.045, 0.032), 0.011, 0.007, (1, 0.5, 1)),
    ),
}
_LIMBS: dict[str, tuple[_Row, ...]] = {
    "upper_arm": (
        ((0.000, -0.002, -0.004), (0.000, -0.003, -0.045), 0.034, 0.028, _ROUND),
        ((0.000, 0.000, -0.040), (0.000, 0.000, -0.186), 0.027, 0.022, (1.08, 0.95, 1)),
    ),
    "forearm": (
        ((0.000, 0.000, 0.000), (0.002, 0.000, -0.050), 0.022, 0.024, _ROUND),
        ((0.002, 0.000, -0.050), (0.000, 0.000, -0.146), 0.024, 0.016, (1, 0.95, 1)),
    ),
    "hand": (
        ((0.000, 0.000, -0.004), (0.001, 0.001, -0.040), 0.015, 0.022, (1, 0.72, 1)),
        ((-0.012, 0.006, -0.050), (0.016, 0.006, -0.050), 0.016, 0.016, (1, 1, 1.05)),
        ((0.014, 0.006, -0.018), (0.026, 0.016, -0.040), 0.009, 0.008, _ROUND),
    ),
    "thigh": (
        ((0.000, 0.006, 0.000), (0.002, 0.000, -0.120), 0.046, 0.043, _ROUND),
        ((0.002, 0.000, -0.120), (0.002, 0.000, -0.245), 0.043, 0.031, _ROUND),
    ),
    "shank": (
        ((0.002, 0.000, 0.000), (0.000, 0.000, -0.120), 0.031, 0.026, _ROUND),
        ((-0.010, 0.000, -0.040), (-0.012, 0.000, -0.090), 0.026, 0.027, _ROUND),
        ((0.000, 0.000, -0.120), (0.000, 0.000, -0.240), 0.026, 0.019, _ROUND),
    ),
    "foot": (
        ((-0.006, 0.000, -0.010), (-0.006, 0.000, -0.020), 0.019, 0.021, (1.05, 0.95, 1)),
        ((0.000, 0.000, -0.008), (0.080, 0.000, -0.030), 0.021, 0.015, (1, 1.15, 1)),
        ((0.070, 0.000, -0.030), (0.098, 0.002, -0.031), 0.022, 0.021, (1, 1.15, 0.6)),
    ),
}


def body_shapes(anthropometry: Anthropometry) -> dict[str, Shape]:
    """The shape of every body of a worker: lengths follow the stature, girths the mass."""
    shapes = {body: _shape(body, rows, anthropometry, 1.0) for body, rows in _TRUNK.items()}
    for side, mirror in zip(SIDES, (1.0, -1.0), strict=True):
        shapes |= {f"{side}_{body}": _shape(body, rows, anthropometry, mirror) for body, rows in _LIMBS.items()}
    return shapes


def capsule_shape(ends: Vector, radius: float) -> Shape:
    """The shape of a capsule with these ends (2, 3) m."""
    return _hull(np.concatenate([end + radius * _unit_sphere(_COARSE_RINGS, _COARSE_PER_RING) for end in ends]))


def _shape(body: str, rows: tuple[_Row, ...], anthropometry: Anthropometry, mirror: float) -> Shape:
    stature = anthropometry.stature_m
    girth = 1.0 if body in _SLENDER else float(np.sqrt(anthropometry.mass_kg / stature / _REFERENCE_KG_PER_M))
    points = stature * np.concatenate([
        np.array(centre) * (1, mirror, 1) + girth * radius * np.array(squeeze) * _unit_sphere()
        for start, end, start_radius, end_radius, squeeze in rows
        for centre, radius in ((start, start_radius), (end, end_radius))
    ])  # fmt: skip
    if body == "foot":  # flat below
        points[:, 2] = np.maximum(points[:, 2], anthropometry.sole_rectangle()[3])
    return _hull(points)


def _hull(points: Vector) -> Shape:
    """The convex hull of points (n, 3) m."""
    hull = ConvexHull(points)
    used, faces = np.unique(hull.simplices, return_inverse=True)
    first, second, third = np.moveaxis(points[hull.simplices], 1, 0)
    inwards = (np.cross(second - first, third - first) * hull.equations[:, :3]).sum(axis=1) < 0
    faces = faces.reshape(-1, 3)
    return Shape(points[used], np.where(inwards[:, None], faces[:, ::-1], faces))


def _unit_sphere(rings: int = _RINGS, per_ring: int = _PER_RING) -> Vector:
    polar, around = np.meshgrid(np.linspace(0, np.pi, rings), 2 * np.pi * np.arange(per_ring) / per_ring)
    sphere = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    return np.unique(np.round(sphere.reshape(-1, 3), 12), axis=0)  # each pole once

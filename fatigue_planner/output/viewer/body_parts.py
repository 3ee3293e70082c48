"""The rounded parts a body is modelled from; they are for the eye only, the mechanics knows nothing of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.skeleton import SIDES

Vector = NDArray[np.float64]
Point = tuple[float, float, float]

# The build of which the girths below are drawn: 75 kg at 1.75 m.
_REFERENCE_KG_PER_M = 75 / 1.75
_SLENDER = ("head", "hand", "foot")  # bodies whose girth does not follow the mass


@dataclass(frozen=True)
class Part:
    """A cone with round ends from `start` to `end`, (3,) m in the body's frame, squeezed across.

    `start_radius` and `end_radius` in m; `squeeze` (3,) multiplies the extent along x, y and z about the start.
    """

    body: str
    start: Vector
    end: Vector
    start_radius: float
    end_radius: float
    squeeze: Vector

    def distance(self, points: Vector) -> Vector:
        """Signed distance in m of points (n, 3) in the body's frame, exact where nothing is squeezed."""
        place = (points - self.start) / self.squeeze
        along = (self.end - self.start) / self.squeeze
        length_squared = float(along @ along)
        share = np.clip(place @ along / length_squared, 0, 1) if length_squared > 0 else np.zeros(len(points))
        radius = self.start_radius + share * (self.end_radius - self.start_radius)
        away = np.linalg.norm(place - share[:, None] * along, axis=1)
        # the gradient's length turns the squeezed distance into one along the surface's normal
        normal = (place - share[:, None] * along) / np.maximum(away, 1e-9)[:, None] / self.squeeze
        return np.asarray((away - radius) / np.maximum(np.linalg.norm(normal, axis=1), 1e-9))


# Shares of stature: body: (start, end, start radius, end radius, squeeze). A part of a limb is that of
# the right one; y changes its sign on the left.
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


def body_parts(anthropometry: Anthropometry) -> tuple[Part, ...]:
    """The parts of a worker: lengths follow the stature, girths the mass."""
    stature = anthropometry.stature_m
    girth = float(np.sqrt(anthropometry.mass_kg / stature / _REFERENCE_KG_PER_M))
    parts = [_part(body, row, stature, girth, 1.0) for body, rows in _TRUNK.items() for row in rows]
    for side in SIDES:
        mirror = 1.0 if side == "right" else -1.0
        for body, rows in _LIMBS.items():
            parts += [_part(f"{side}_{body}", row, stature, girth, mirror) for row in rows]
    return tuple(parts)


def _part(body: str, row: _Row, stature: float, girth: float, mirror: float) -> Part:
    start, end, start_radius, end_radius, squeeze = row
    turned = stature * np.array([1.0, mirror, 1.0])
    scale = stature if body.endswith(_SLENDER) else stature * girth
    return Part(
        body, np.array(start) * turned, np.array(end) * turned, start_radius * scale, end_radius * scale,
        np.array(squeeze, dtype=float),
    )  # fmt: skip

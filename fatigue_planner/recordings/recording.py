"""A recording as everything after reading knows it: SI units, z up, evenly sampled, nobody named."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.files import canonical_json, digest_of_bytes
from fatigue_planner.recordings.content import Angles, Segments

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class GroundForce:
    """What a plate does to the person: force (m, 3) N, moment about the world's origin (m, 3) N.m; corners (4, 3) m."""

    force_n: Vector
    moment_nm: Vector
    corners_m: Vector | None = None

    def centre_m(self, least_n: float = 20.0) -> Vector:
        """Where the force acts at height 0, (m, 2) m; NaN where less than `least_n` presses."""
        up = np.where(abs(self.force_n[:, 2]) < least_n, np.nan, self.force_n[:, 2])
        return np.column_stack([-self.moment_nm[:, 1] / up, self.moment_nm[:, 0] / up])


@dataclass(frozen=True)
class Recording:
    """A recorded motion. World: z up, and x where the person first faces, if that is known.

    rate_hz: of the frames, which begin at 0 s; labels (k) and points_m (n, k, 3), NaN where a point was not seen: of
    markers, or of the origins of segments; segments, angles: what the file has of them; ground: the plates, sampled at
    ground_rate_hz from 0 s on.
    """

    rate_hz: float
    frames: int
    labels: tuple[str, ...] = ()
    points_m: Vector | None = None
    segments: Segments | None = None
    angles: Angles | None = None
    ground: tuple[GroundForce, ...] = ()
    ground_rate_hz: float = 0.0

    @property
    def duration_s(self) -> float:
        """Time from the first frame to the last."""
        return (self.frames - 1) / self.rate_hz

    @property
    def digest(self) -> str:
        """SHA-256 of all numbers and labels, in hex: the same for every encoding that says exactly the same."""
        angles = None if self.angles is None else [self.angles.names, sorted(self.angles.lengths)]
        names = None if self.segments is None else self.segments.names
        head = [self.rate_hz, self.frames, self.labels, names, angles, self.ground_rate_hz, len(self.ground)]
        arrays = [self.points_m]
        arrays += [self.segments.position, self.segments.rotation] if self.segments else []
        arrays += [self.angles.value] if self.angles else []
        arrays += [array for plate in self.ground for array in (plate.force_n, plate.moment_nm)]
        content = [canonical_json(head).encode()]
        content += [np.ascontiguousarray(array).tobytes() for array in arrays if array is not None]
        return digest_of_bytes(b"\0".join(content))

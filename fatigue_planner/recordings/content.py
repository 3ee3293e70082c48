"""What a file of a recording says, in its own units and axes, before anything is inferred."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Points:
    """Points in space: labels (k) and positions (n, k, 3), NaN where one was not seen."""

    labels: tuple[str, ...]
    position: Vector


@dataclass(frozen=True)
class Segments:
    """Poses of bodies: names (s), positions of their origins (n, s, 3) and orientations (n, s, 3, 3) in the world.

    rest (s, 3) is where the origins are when nothing is turned, if the file says so.
    """

    names: tuple[str, ...]
    position: Vector
    rotation: Vector
    rest: Vector | None = None


@dataclass(frozen=True)
class Angles:
    """Coordinates of a model: names (a) and values (n, a), rad, or lengths for those in `lengths`; NaN if missing."""

    names: tuple[str, ...]
    value: Vector
    lengths: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Plate:
    """A force plate: force (m, 3) N, moment (m, 3) about `origin` (m, 3), in the file's axes.

    unit: of origin, corners and, with N, of the moment; None: the file's. corners: (4, 3), if known; kind: the plate's
    type in C3D.
    """

    force_n: Vector
    moment: Vector
    origin: Vector
    unit: str | None = None
    corners: Vector | None = None
    kind: int | None = None


@dataclass(frozen=True)
class Remark:
    """What a user should know of a file; fault: its number in docs/recordings.md."""

    fault: int
    text: str


@dataclass(frozen=True)
class Content:
    """What a file says.

    times_s: (n,), as in the file; stated_rate_hz, unit, up: what its header says, if it does; plate_times_s (m,): the
    times of the plates' samples.
    """

    format: str
    times_s: Vector
    stated_rate_hz: float | None = None
    unit: str | None = None
    up: str | None = None
    points: Points | None = None
    segments: Segments | None = None
    angles: Angles | None = None
    plates: tuple[Plate, ...] = ()
    plate_times_s: Vector = field(default_factory=lambda: np.empty(0))
    remarks: tuple[Remark, ...] = ()

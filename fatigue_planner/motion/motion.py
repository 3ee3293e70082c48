"""What a simulation leaves: the motion of one cycle."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


class Phase(NamedTuple):
    """A part of the cycle, as ticks [start, stop)."""

    name: str
    start: int
    stop: int


@dataclass(frozen=True)
class Motion:
    """A simulated cycle of T ticks; row i is the instant i * time_step_s and holds until the next.

    configuration (T, 46), velocity (T, 45), acceleration (T, 45), torque_nm (T, 39), wrench (T, 12)
    as in `Human` and `WholeBodyController`; hand_error_m (T,) the distance of the right fist from its
    reference; foot_displacement_m (T, 2) of the right and left sole from their place.
    """

    time_step_s: float
    phases: tuple[Phase, ...]
    configuration: Matrix
    velocity: Matrix
    acceleration: Matrix
    torque_nm: Matrix
    wrench: Matrix
    hand_error_m: Vector
    foot_displacement_m: Matrix

    def phase(self, name: str) -> slice:
        """The ticks of a phase."""
        return next(slice(phase.start, phase.stop) for phase in self.phases if phase.name == name)

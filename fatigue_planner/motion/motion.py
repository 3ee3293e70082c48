"""The result of a simulation: the motion of one cycle."""

from dataclasses import dataclass, fields
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
    as in `Human` and `WholeBodyController`; hand_force_n (T, 6) the forces on the right and left hand
    in world axes (masses held are not among them, they are part of the body); hand_error_m (T,) how far
    a hand is from its reference, the larger of both; eased_radps2 (T, 39) how far joint accelerations
    left their bounds because there was no solution within them; tissue_nm (T, 39) what passive tissue and
    stops exert on the joints: with torque_nm, which the muscles exert, it is the whole joint torque.
    """

    time_step_s: float
    phases: tuple[Phase, ...]
    configuration: Matrix
    velocity: Matrix
    acceleration: Matrix
    torque_nm: Matrix
    wrench: Matrix
    hand_force_n: Matrix
    hand_error_m: Vector
    eased_radps2: Matrix
    tissue_nm: Matrix

    def phase(self, name: str) -> slice:
        """The ticks of a phase."""
        return next(slice(phase.start, phase.stop) for phase in self.phases if phase.name == name)

    def middle(self, name: str) -> int:
        """The tick in the middle of a phase."""
        ticks = self.phase(name)
        return int(ticks.start + ticks.stop) // 2


# The arrays of a motion, one row per tick.
ROWS = tuple(field.name for field in fields(Motion) if field.name not in {"time_step_s", "phases"})

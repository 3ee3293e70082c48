"""Time in the fatigue POMDP: rest, and cycles that take another time than planned.

The worker chooses by the cost of the cycle that is planned (Eq. 4): nobody knows yet how long it will take. What it
did to him depends on the time it took:

- A longer cycle is the planned one, then rest. Robots wait for workers and workers for parts; what is known is the time
  between two cycles. A reaction that itself took longer tires more than that.
- A shorter one is the whole reaction at the same loads in less time: an assumption, good where weight loads more than
  acceleration does. Every fatigue law is linear in its rates, df/dt = F a - (F b + R c) f, so a cycle in the share s of
  its time is one with all rates multiplied by s: `CycleProfile.maps` has it in closed form. The share is a multiple of
  1 / SHARES, so that a belief in many workers needs few maps; what is missing to the time is rest.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.fatigue.model import Rest

SHARES = 100


class Pace(NamedTuple):
    """How a cycle went: the reaction took a share of the planned duration, at most 1; then there was rest, in s."""

    share: float = 1.0
    rest_s: float = 0.0


AS_PLANNED = Pace()


@dataclass(frozen=True)
class Timing:
    """The planned duration of a cycle in s, and what time without load does to the worker."""

    cycle_s: float
    rest: Rest

    def pace(self, duration_s: float) -> Pace:
        """How a cycle of some duration is taken to have gone. Raises ProblemError for what is no duration."""
        duration_s = checked_seconds(duration_s)
        if duration_s >= self.cycle_s:
            return Pace(1.0, duration_s - self.cycle_s)
        share = math.floor(SHARES * duration_s / self.cycle_s) / SHARES
        return Pace(share, duration_s - share * self.cycle_s)


def checked_seconds(seconds: float) -> float:
    """The time as a number. Raises ProblemError if it is negative or not finite."""
    if not isinstance(seconds, int | float | np.number) or not 0 <= seconds < math.inf:
        raise ProblemError(f"{seconds!r} is no time in seconds; give a finite number that is not negative.")
    return float(seconds)

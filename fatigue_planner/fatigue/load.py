"""How a motion loads the entries, as fractions of a worker's strength."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.fatigue.parameters import FatigueParameters

Matrix = NDArray[np.float64]


class Exertion(Protocol):
    """What of a motion tires: torques (T, 39) N.m that each hold for a time step (see `motion.motion.Motion`)."""

    @property
    def time_step_s(self) -> float:
        """Length of a tick in s."""

    @property
    def torque_nm(self) -> Matrix:
        """Joint torques (T, 39) in N.m."""


def loads(torque_nm: Matrix) -> Matrix:
    """Load of each entry (T, 78) N.m from joint torques (T, 39): positive part, then negative part."""
    return np.hstack([np.maximum(torque_nm, 0), np.maximum(-torque_nm, 0)])


def load_share(motion: Exertion, parameters: FatigueParameters) -> Matrix:
    """Load of each entry (T, 78) as a fraction of the worker's strength."""
    return np.asarray(loads(motion.torque_nm) / parameters.maximum_torque_nm)


def cycle_profile(motion: Exertion, parameters: FatigueParameters) -> CycleProfile:
    """How the cycle of a motion loads a worker."""
    return parameters.law.profile(load_share(motion, parameters), motion.time_step_s, parameters)

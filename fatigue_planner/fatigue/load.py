"""How a motion loads the entries, as fractions of a worker's strength."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM

Matrix = NDArray[np.float64]


class Exertion(Protocol):
    """What of a motion tires: torques that each hold for a time step, and postures (see `motion.motion.Motion`)."""

    @property
    def time_step_s(self) -> float:
        """Length of a tick in s."""

    @property
    def torque_nm(self) -> Matrix:
        """Joint torques (T, 39) in N.m."""

    @property
    def configuration(self) -> Matrix:
        """Configurations (T, 46); the last 39 are the joint angles in rad."""


def loads(torque_nm: Matrix) -> Matrix:
    """Load of each entry (T, 78) N.m from joint torques (T, 39): positive part, then negative part."""
    return np.hstack([np.maximum(torque_nm, 0), np.maximum(-torque_nm, 0)])


def strength_nm(motion: Exertion, parameters: FatigueParameters) -> Matrix:
    """The worker's strength in N.m during a motion: (T, 78), or (1, 78) where it does not depend on the angle."""
    constant = parameters.maximum_torque_nm[None]
    if parameters.by_angle is None:
        return constant
    return np.asarray(constant * parameters.by_angle.factors(motion.configuration[:, -len(DEGREES_OF_FREEDOM) :]))


def load_share(motion: Exertion, parameters: FatigueParameters) -> Matrix:
    """Load of each entry (T, 78) as a fraction of the worker's strength at that angle."""
    return np.asarray(loads(motion.torque_nm) / strength_nm(motion, parameters))


def cycle_profile(motion: Exertion, parameters: FatigueParameters) -> CycleProfile:
    """How the cycle of a motion loads a worker."""
    return parameters.law.profile(load_share(motion, parameters), motion.time_step_s, parameters)

"""What one cycle does to fatigue: an exact affine map per entry."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.fatigue.parameters import FatigueParameters

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class CycleMap:
    """f' = gain * f + offset for each of the 78 entries; gain and offset are (78,), in [0, 1]."""

    gain: Vector
    offset: Vector

    def apply(self, fatigue: Vector) -> Vector:
        """Fatigue (78,) after the cycle."""
        return self.gain * fatigue + self.offset


def loads(torque_nm: Matrix) -> Matrix:
    """Load of each entry (T, 78) N.m from joint torques (T, 39): positive part, then negative part."""
    return np.hstack([np.maximum(torque_nm, 0), np.maximum(-torque_nm, 0)])


def cycle_map(torque_nm: Matrix, time_step_s: float, parameters: FatigueParameters) -> CycleMap:
    r"""The map of a cycle whose torques (T, 39) each hold for a time step.

    Paper, Eq. 2, for the fatigue f = 1 - tau_cem / tau_max of Eq. 1:
        tau_load > alpha tau_max:  d(1 - f)/dt = -k (tau_load / tau_max) (1 - f)
        else:                      df/dt = -R f
    Its mode depends on the load alone, so over a tick f' = g f + (1 - g) with g = exp(-k load/max dt)
    (fatigue) or f' = g f with g = exp(-R dt) (recovery), and the product of the ticks is affine and
    exact. At tau_load = alpha tau_max, which Eq. 2 leaves open, the entry recovers.
    """
    share = loads(torque_nm) / parameters.maximum_torque_nm
    tiring = share > parameters.threshold
    rate = np.where(tiring, parameters.fatigue_rate * share, parameters.recovery_rate)
    # log of the product of the gains of all later ticks
    later = np.zeros_like(rate)
    later[:-1] = np.cumsum(rate[:0:-1], axis=0)[::-1]
    added = np.where(tiring, -np.expm1(-rate * time_step_s), 0.0)
    return CycleMap(
        gain=np.exp(-rate.sum(axis=0) * time_step_s),
        offset=(added * np.exp(-later * time_step_s)).sum(axis=0),
    )

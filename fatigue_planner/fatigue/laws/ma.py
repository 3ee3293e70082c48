"""Ma's law (Ma et al. 2009): the paper's Eq. 2."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from fatigue_planner.fatigue.laws.law import FatigueLaw, Matrix, Rates, Vector
from fatigue_planner.fatigue.model import CycleProfile, Flows


@dataclass(frozen=True)
class DoseProfile(CycleProfile):
    r"""How a cycle loads each entry under Ma's law: the runs of ticks in which it tires.

    With the shares s = tau_load / tau_max of a worker's strength and threshold alpha, run i of
    consecutive ticks with s > alpha has the dose D_i, the integral of s dt over it, in s.

        dose_s        (runs, 78)  D_i; 0 where an entry has fewer runs
        later_dose_s  (runs, 78)  the doses of all later runs
        later_rest_s  (runs, 78)  the time without tiring after run i
        rest_s        (78,)       the time without tiring in the whole cycle

    fatigue_rate, recovery_rate (78,), in 1/s: k and R of the worker, as the experiment gives them.
    """

    dose_s: Matrix
    later_dose_s: Matrix
    later_rest_s: Matrix
    rest_s: Vector
    fatigue_rate: Vector
    recovery_rate: Vector

    @property
    def tires(self) -> NDArray[np.bool_]:
        """See CycleProfile.tires."""
        return np.asarray((self.dose_s > 0).any(axis=0))

    @property
    def load_s(self) -> Vector:
        """See CycleProfile.load_s."""
        return np.asarray(self.dose_s.sum(axis=0))

    def maps(self, fatigue_rate_factor: ArrayLike, recovery_rate_factor: ArrayLike) -> tuple[Matrix, Matrix]:
        r"""See CycleProfile.maps.

        Paper, Eq. 2, for the fatigue f = 1 - tau_cem / tau_max of Eq. 1:
            tau_load > alpha tau_max:  d(1 - f)/dt = -k (tau_load / tau_max) (1 - f)
            else:                      df/dt = -R f
        The mode depends on the load alone. Run i multiplies 1 - f by exp(-k D_i), rest of length t multiplies
        f by exp(-R t), and the product of these affine maps is
            gain   = exp(-k sum_i D_i - R t_rest)
            offset = sum_i (1 - exp(-k D_i)) exp(-k D_later,i - R t_later,i).
        """
        k = np.asarray(fatigue_rate_factor)[..., None] * self.fatigue_rate
        R = np.asarray(recovery_rate_factor)[..., None] * self.recovery_rate
        gain = np.exp(-k * self.dose_s.sum(axis=0) - R * self.rest_s)
        offset = np.zeros_like(gain)
        for dose, later_dose, later_rest in zip(self.dose_s, self.later_dose_s, self.later_rest_s, strict=True):
            tires = dose > 0  # few entries do; the others get nothing
            fast, slow = k[..., tires], R[..., tires]
            offset[..., tires] += -np.expm1(-fast * dose[tires]) * np.exp(
                -fast * later_dose[tires] - slow * later_rest[tires]
            )
        return gain, offset


class MaLaw(FatigueLaw):
    """The paper's law: d(1 - f)/dt = -k s (1 - f) under a load s above the threshold, else df/dt = -R f."""

    kind: Literal["ma"] = Field(description="The paper's Eq. 2 (Ma et al. 2009), with its k and R.")

    def flows(self, share: Matrix, rates: Rates) -> Flows:
        """See FatigueLaw.flows. At tau_load = alpha tau_max, which Eq. 2 leaves open, the entry rests."""
        tiring = share > rates.threshold
        loaded = np.where(tiring, share, 0.0)
        return Flows(loaded, loaded, (~tiring).astype(float))

    def profile(self, share: Matrix, time_step_s: float, rates: Rates) -> CycleProfile:
        """See FatigueLaw.profile. The same map from sums over the runs, for many workers at once."""
        tiring = share > rates.threshold
        entries = share.shape[1]
        before = np.zeros((1, entries), dtype=bool)
        begins = tiring & ~np.vstack([before, tiring[:-1]])
        ends = tiring & ~np.vstack([tiring[1:], before])
        dose = np.vstack([np.zeros((1, entries)), np.cumsum(np.where(tiring, share, 0.0), axis=0)]) * time_step_s
        rest = np.vstack([np.zeros((1, entries)), np.cumsum(~tiring, axis=0)]) * time_step_s
        shape = (int(begins.sum(axis=0).max()), entries)
        runs, later_dose, later_rest = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        for entry in range(entries):
            first, last = np.flatnonzero(begins[:, entry]), np.flatnonzero(ends[:, entry]) + 1
            runs[: first.size, entry] = dose[last, entry] - dose[first, entry]
            later_dose[: first.size, entry] = dose[-1, entry] - dose[last, entry]
            later_rest[: first.size, entry] = rest[-1, entry] - rest[last, entry]
        return DoseProfile(runs, later_dose, later_rest, rest[-1], rates.fatigue_rate, rates.recovery_rate)

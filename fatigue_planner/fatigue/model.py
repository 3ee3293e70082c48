"""What one cycle does to fatigue: an exact affine map per entry, for any worker's rates."""

import hashlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fatigue_planner.core.jit import kernel

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


@dataclass(frozen=True)
class CycleProfile(ABC):
    """How a cycle loads each entry under a fatigue law, whatever the worker's rates.

    posture_cost: what the posture of the cycle adds to the cost, in the cost's unit; 0 in the paper.
    """

    posture_cost: float = field(default=0.0, kw_only=True)

    @property
    @abstractmethod
    def tires(self) -> NDArray[np.bool_]:
        """Which entries the cycle tires at all, (78,)."""

    @property
    @abstractmethod
    def load_s(self) -> Vector:
        """The integral of the load over the ticks of the cycle in which it tires, in s, (78,).

        Under the laws that ship: of tau_load / tau_max where that is above the threshold.
        """

    @abstractmethod
    def maps(self, fatigue_rate_factor: ArrayLike, recovery_rate_factor: ArrayLike) -> tuple[Matrix, Matrix]:
        """Gains and offsets (..., 78) with all rates multiplied by factors (...)."""

    def cycle_map(self) -> CycleMap:
        """The cycle's map with the worker's own rates."""
        gain, offset = self.maps(1.0, 1.0)
        return CycleMap(gain, offset)

    def plain(self) -> dict[str, Any]:
        """The profile as JSON values."""
        return {name: np.asarray(values).tolist() for name, values in vars(self).items()}


@dataclass(frozen=True)
class Flows:
    """A fatigue law during T ticks, each (T, 78), per unit of the rates: df/dt = F a - (F b + R c) f.

    tiring: a, what adds to fatigue. slowing: b, how much less an entry tires the more it is tired already.
    recovering: c, 1 at the rate R.
    """

    tiring: Matrix
    slowing: Matrix
    recovering: Matrix


@dataclass(frozen=True)
class TickProfile(CycleProfile):
    """The profile of any law that is affine in fatigue: its flows, tick by tick.

    entries (n,): those that tire; flows: theirs, (T, n); slowing_s, recovering_s (78,): the integrals of b and c over
    the cycle, in s; fatigue_rate, recovery_rate (78,), in 1/s: F and R of the worker.
    """

    entries: NDArray[np.intp]
    flows: Flows
    slowing_s: Vector
    recovering_s: Vector
    time_step_s: float
    fatigue_rate: Vector
    recovery_rate: Vector

    @classmethod
    def of(cls, flows: Flows, time_step_s: float, fatigue_rate: Vector, recovery_rate: Vector) -> "TickProfile":
        """The profile of a cycle with flows (T, 78) that each hold for a time step."""
        entries = np.flatnonzero((flows.tiring > 0).any(axis=0))
        return cls(
            entries,
            Flows(*(np.ascontiguousarray(table[:, entries]) for table in vars(flows).values())),
            flows.slowing.sum(axis=0) * time_step_s,
            flows.recovering.sum(axis=0) * time_step_s,
            time_step_s,
            fatigue_rate,
            recovery_rate,
        )

    @property
    def tires(self) -> NDArray[np.bool_]:
        """See CycleProfile.tires."""
        return np.isin(np.arange(self.fatigue_rate.size), self.entries)

    @property
    def load_s(self) -> Vector:
        """See CycleProfile.load_s."""
        load_s = np.zeros(self.fatigue_rate.size)
        load_s[self.entries] = self.flows.tiring.sum(axis=0) * self.time_step_s
        return load_s

    def maps(self, fatigue_rate_factor: ArrayLike, recovery_rate_factor: ArrayLike) -> tuple[Matrix, Matrix]:
        """See CycleProfile.maps: the gain is exp(-integral of F b + R c), the offset is summed tick by tick."""
        faster, sooner = np.broadcast_arrays(
            np.asarray(fatigue_rate_factor, float), np.asarray(recovery_rate_factor, float)
        )
        F, R = faster[..., None] * self.fatigue_rate, sooner[..., None] * self.recovery_rate
        gain = np.exp(-F * self.slowing_s - R * self.recovering_s)
        offset = np.zeros_like(gain)
        tired = np.zeros((faster.size, self.entries.size))
        own = [rates.reshape(faster.size, -1)[:, self.entries] for rates in (F, R)]
        flows = self.flows
        add_ticks(flows.tiring, flows.slowing, flows.recovering, own[0], own[1], self.time_step_s, tired)
        offset[..., self.entries] = tired.reshape(*faster.shape, -1)
        return gain, offset

    def plain(self) -> dict[str, Any]:
        """See CycleProfile.plain; of the flows, which are many, the SHA-256."""
        flows = {name: hashlib.sha256(table.tobytes()).hexdigest() for name, table in vars(self.flows).items()}
        return {name: np.asarray(value).tolist() for name, value in vars(self).items() if name != "flows"} | flows


@dataclass(frozen=True)
class Rest:
    """What time without load does to fatigue under a law: df/dt = tiring - (slowing + recovering) f, each (78,) in 1/s.

    tiring, slowing: F a and F b of the law without load; recovering: R c. See `Flows`.
    """

    tiring: Vector
    slowing: Vector
    recovering: Vector

    def rates(self, fatigue_rate_factor: ArrayLike, recovery_rate_factor: ArrayLike) -> tuple[Matrix, Matrix]:
        """How fast fatigue fades and grows, (..., 78) in 1/s, with all rates multiplied by factors (...)."""
        faster, sooner = (
            np.asarray(factor, float)[..., None] for factor in (fatigue_rate_factor, recovery_rate_factor)
        )
        return faster * self.slowing + sooner * self.recovering, faster * self.tiring

    def maps(
        self, fatigue_rate_factor: ArrayLike, recovery_rate_factor: ArrayLike, seconds: float
    ) -> tuple[Matrix, Matrix]:
        """Gains and offsets (..., 78) of a rest of `seconds`, with all rates multiplied by factors (...).

        It is exact for any time, so a rest of a and one of b seconds are one of a + b.
        """
        fade, grow = self.rates(fatigue_rate_factor, recovery_rate_factor)
        held = np.where(fade > 0, -np.expm1(-fade * seconds) / np.where(fade > 0, fade, 1.0), seconds)
        return np.exp(-fade * seconds), grow * held


@kernel
def add_ticks(
    tiring: Matrix, slowing: Matrix, recovering: Matrix, F: Matrix, R: Matrix, time_step_s: float, fatigue: Matrix
) -> None:
    """Take fatigue (M, n) in place through T ticks of flows (T, n) with rates F and R (M, n), each tick exactly.

    f' = e f + F a (1 - e) / q with q = F b + R c and e = exp(-q dt). Neighbouring ticks often have the same q.
    """
    for m in range(fatigue.shape[0]):
        for j in range(fatigue.shape[1]):
            f, last, left, held = fatigue[m, j], -1.0, 1.0, time_step_s
            for t in range(tiring.shape[0]):
                q = F[m, j] * slowing[t, j] + R[m, j] * recovering[t, j]
                if q != last:
                    left = np.exp(-q * time_step_s)
                    held = -np.expm1(-q * time_step_s) / q if q > 0 else time_step_s
                    last = q
                f = left * f + F[m, j] * tiring[t, j] * held
            fatigue[m, j] = f

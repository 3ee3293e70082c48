"""What a fatigue law is: how fast fatigue grows under a load and fades without.

A law is affine in fatigue: df/dt = F a - (F b + R c) f, where a, b and c depend on the load alone and F and R are the
rates of an entry. So a whole cycle is an affine map, too, and planning needs no integrator.
"""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.plugins import Registry
from fatigue_planner.core.settings import Settings
from fatigue_planner.fatigue.model import CycleProfile, Flows, Rest, TickProfile

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Rates:
    """The rates of the entries, each (78,).

    fatigue_rate, recovery_rate: F (Ma's k) and R in 1/s; rest_multiplier: by which R grows at rest; threshold: the load
    up to which an entry rests, as a fraction of its strength.
    """

    fatigue_rate: Vector
    recovery_rate: Vector
    rest_multiplier: Vector
    threshold: Vector


class FatigueLaw(Settings):
    """A fatigue law; every kind has `kind: Literal["its name"]`, keys of its own, and says its `flows`.

    >>> experiment.fatigue.law.kind
    'ma'
    """

    kind: str

    @property
    def rests_faster(self) -> bool:
        """Whether the law uses `rest_multiplier`."""
        return False

    @property
    def rates_of(self) -> str:
        """The kind of the law whose sets of rates it takes."""
        return self.kind

    @abstractmethod
    def flows(self, share: Matrix, rates: Rates) -> Flows:
        """The law under loads (T, 78), as fractions of strength; at a load equal to the threshold an entry rests."""

    def profile(self, share: Matrix, time_step_s: float, rates: Rates) -> CycleProfile:
        """The profile of a cycle whose loads (T, 78) each hold for a time step."""
        return TickProfile.of(self.flows(share, rates), time_step_s, rates.fatigue_rate, rates.recovery_rate)

    def rest(self, rates: Rates) -> Rest:
        """What time without load does."""
        flows = self.flows(np.zeros((1, rates.threshold.size)), rates)
        return Rest(
            rates.fatigue_rate * flows.tiring[0],
            rates.fatigue_rate * flows.slowing[0],
            rates.recovery_rate * flows.recovering[0],
        )

    def rest_rate(self, rates: Rates) -> Vector:
        """How fast fatigue fades at rest, in 1/s, (78,)."""
        rest = self.rest(rates)
        return np.asarray(rest.slowing + rest.recovering)

    def endurance_s(self, share: float, rates: Rates) -> Vector:
        """How long a rested entry can hold a load, as a fraction of its strength, in s, (78,): until f = 1 - share.

        Infinite where it never comes to that.
        """
        flows = self.flows(np.full((1, rates.threshold.size), share), rates)
        grow = rates.fatigue_rate * flows.tiring[0]
        fade = rates.fatigue_rate * flows.slowing[0] + rates.recovery_rate * flows.recovering[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            left = 1 - fade * (1 - share) / grow  # exp(-fade t)
            times = np.where(fade > 0, -np.log(left) / fade, (1 - share) / grow)
        return np.where(left > 0, times, np.inf)


LAWS = Registry("fatigue law", FatigueLaw)  # type: ignore[type-abstract]

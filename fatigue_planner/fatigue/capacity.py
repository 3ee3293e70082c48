"""Where a task asks for more than is left: a load s, of the strength, above the remaining capacity 1 - f."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.fatigue.load import Exertion, load_share
from fatigue_planner.fatigue.parameters import FatigueParameters

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Shortfall:
    """The first load that cannot be met: the cycle (from 1), the entry, and the time in the cycle in s."""

    cycle: int
    entry: str
    time_s: float


@dataclass(frozen=True)
class Capacity:
    """What a cycle asks for, against what is left of a worker who begins it with some fatigue.

    A worker with fatigue f at its start has fatigue gain f + offset after each tick, both (T, 78), and is asked for the
    share (T, 78) of his strength. highest_start (78,): the fatigue at the start up to which all loads can be met; below
    0 not even rested.
    """

    share: Matrix
    gain: Matrix
    offset: Matrix
    time_step_s: float
    highest_start: Vector

    def first_shortfall(self, start: Vector, cycle: int = 1) -> Shortfall | None:
        """The first load that a worker with fatigue `start` (78,) cannot meet in this `cycle`, if there is one."""
        short = np.flatnonzero(start > self.highest_start)
        if short.size == 0:
            return None
        left = 1 - (self.gain[:, short] * start[short] + self.offset[:, short])
        ticks = (self.share[:, short] > left).argmax(axis=0)
        first = int(ticks.argmin())
        return Shortfall(cycle, ENTRIES[short[first]], float(ticks[first]) * self.time_step_s)

    def if_repeated(self) -> Shortfall | None:
        """The first load that a worker cannot meet who starts rested and repeats the cycle for ever."""
        gain, offset = self.gain[-1], self.offset[-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            settled = np.where(offset > 0, offset / (1 - gain), 0.0)
            # after n cycles fatigue is settled (1 - gain^n); without recovery, n offset
            faded = np.log(1 - self.highest_start / settled) / np.log(gain)
            done = np.where(gain < 1, faded, self.highest_start / offset)
        done = np.where(settled > self.highest_start, done, np.inf)
        soonest = float(np.where(self.highest_start < 0, -1.0, done).min())
        if math.isinf(soonest):
            return None
        cycle = math.floor(soonest) + 2
        while True:
            start = np.where(gain < 1, settled * (1 - gain ** (cycle - 1)), (cycle - 1) * offset)
            if found := self.first_shortfall(start, cycle):
                return found
            cycle += 1  # the logarithm was rounded


def capacity(motion: Exertion, parameters: FatigueParameters) -> Capacity:
    """What the cycle of a motion asks of a worker."""
    share, step = load_share(motion, parameters), motion.time_step_s
    flows = parameters.law.flows(share, parameters)
    fade = parameters.fatigue_rate * flows.slowing + parameters.recovery_rate * flows.recovering
    left = np.exp(-fade * step)
    with np.errstate(divide="ignore", invalid="ignore"):
        held = np.where(fade > 0, -np.expm1(-fade * step) / fade, step)
    added = parameters.fatigue_rate * flows.tiring * held
    gain, offset = np.asarray(np.cumprod(left, axis=0), float), np.empty_like(left)
    total = np.zeros(share.shape[1])
    for tick in range(len(share)):
        total = left[tick] * total + added[tick]
        offset[tick] = total
    highest = ((1 - share - offset) / gain).min(axis=0)
    return Capacity(share, gain, offset, step, highest)

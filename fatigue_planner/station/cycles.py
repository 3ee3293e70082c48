"""A whole cycle of several operations: their motions one after another, then rest in the stance, for ever."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.fatigue.capacity import Shortfall, capacity
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.fatigue.load import cycle_profile
from fatigue_planner.fatigue.model import CycleMap
from fatigue_planner.fatigue.parameters import FatigueParameters
from fatigue_planner.motion.motion import Motion

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Stretch:
    """A part of a cycle as what tires of it (see `fatigue.load.Exertion`)."""

    time_step_s: float
    torque_nm: Matrix
    configuration: Matrix

    @classmethod
    def of(cls, motion: Motion, ticks: slice = slice(None)) -> Self:
        """The ticks of a motion."""
        return cls(motion.time_step_s, motion.torque_nm[ticks], motion.configuration[ticks])

    @classmethod
    def rest(cls, motion: Motion, seconds: float) -> Self:
        """Rest in which no joint is loaded, whoever stands or sits: in the stance in which a motion begins."""
        first = np.zeros(round(seconds / motion.time_step_s), dtype=np.intp)
        return cls(motion.time_step_s, 0 * motion.torque_nm[first], motion.configuration[first])

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Some parts, one after another."""
        torques, configurations = ([getattr(part, name) for part in parts] for name in ("torque_nm", "configuration"))
        return cls(parts[0].time_step_s, np.vstack(torques), np.vstack(configurations))


@dataclass(frozen=True)
class Course:
    """What a motion does to fatigue, as exact affine maps: to the end of its work; on the way back; a second of rest.

    A cycle that holds several is the product of their maps.
    """

    work: CycleMap
    back: CycleMap
    rest_per_s: CycleMap

    @classmethod
    def of(cls, motion: Motion, parameters: FatigueParameters) -> Self:
        """The course of a motion."""
        work = slice(0, motion.phase("work").stop)
        parts = (Stretch.of(motion, work), Stretch.of(motion, motion.phase("return")), Stretch.rest(motion, 1.0))
        return cls(*(cycle_profile(part, parameters).cycle_map() for part in parts))

    def rest(self, seconds: float) -> CycleMap:
        """The map of a rest: in n seconds, fatigue falls by the gain of a second to the power of n."""
        return CycleMap(self.rest_per_s.gain**seconds, 0 * self.rest_per_s.offset)


def settled(courses: Sequence[Course], rest_s: float) -> Matrix:
    """Fatigue (n, 78) at the end of every work, in the cycle to which repeating it for ever leads.

    courses (n): of the cycle in their order; rest_s: the rest of it.
    """
    maps = [each for course in courses for each in (course.work, course.back)]
    maps.append(courses[-1].rest(rest_s))
    whole = product(maps)
    without_end = np.where(whole.offset > 0, 1.0, 0.0)
    now = np.divide(whole.offset, 1 - whole.gain, out=without_end, where=whole.gain < 1)
    ends = []
    for index, each in enumerate(maps[:-1]):
        now = each.apply(now)
        if index % 2 == 0:
            ends.append(now)
    return np.array(ends)


def product(maps: Sequence[CycleMap]) -> CycleMap:
    """One map for some, one after another."""
    gain, offset = np.ones_like(maps[0].gain), np.zeros_like(maps[0].gain)
    for each in maps:
        gain, offset = each.gain * gain, each.apply(offset)
    return CycleMap(gain, offset)


def cost(ends: Matrix) -> float:
    """Mean squared fatigue (Eq. 5) of a settled cycle, over the ends of its work."""
    return float(np.mean(ends**2))


def peak(ends: Matrix) -> tuple[float, str]:
    """The highest fatigue in a settled cycle, and the entry that it is of; none if nothing tires."""
    highest = ends.max(axis=0)
    entry = int(highest.argmax())
    return float(highest[entry]), ENTRIES[entry] if highest[entry] > 0 else ""


def shortfall(motions: Sequence[Motion], rest_s: float, parameters: FatigueParameters) -> Shortfall | None:
    """The first load that a worker cannot meet who starts rested and repeats these motions, then rests, for ever."""
    parts = [*map(Stretch.of, motions), Stretch.rest(motions[-1], rest_s)]
    return capacity(Stretch.joined(parts), parameters).if_repeated()

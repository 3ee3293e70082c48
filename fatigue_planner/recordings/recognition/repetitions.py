"""Labelled repetitions: joint angles over the phases of a cycle, and who did what how."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.core.settings import Seed, Settings
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.settings import PHASES, Cycle
from fatigue_planner.reactions.reaction import Reaction

Array = NDArray[np.float64]

# Into how many parts of equal duration a phase is divided; the angles of a part are its mean.
PARTS = {"reach": 10, "work": 5, "return": 5}
N_PARTS = sum(PARTS.values())
WORK = slice(PARTS["reach"], PARTS["reach"] + PARTS["work"])
# Instants of a part from which the error of its mean is computed.
INSTANTS = 10
CLOCK_S = 1e-6  # by how much an instant may be off by rounding


class CaptureError(Settings):
    """What motion capture adds to joint angles: a constant of the session, and what changes slowly."""

    offset_deg: float = Field(
        default=5.0,
        ge=0,
        le=30,
        description="Standard deviation in degrees of the error that a joint has during all of a person's repetitions.",
    )
    noise_deg: float = Field(
        default=3.0,
        ge=0,
        le=30,
        description="Standard deviation in degrees of the error that changes during a repetition.",
    )
    correlation_time_s: float = Field(
        default=1.0,
        gt=0,
        le=100,
        description="Time in s after which the changing error is correlated by 1/e with what it was.",
    )
    repetitions: int = Field(
        default=20, ge=1, le=1000, description="How often every person repeats every reaction, without unit."
    )
    seed: Seed = Field(default=0, description="Seed of the errors, without unit.")


@dataclass(frozen=True)
class Repetitions:
    """N repetitions; who (N,), the action (N,), the preference (N,), and angles (N, N_PARTS, J) in degrees.

    An angle that was not measured is NaN.
    """

    people: NDArray[np.str_]
    actions: NDArray[np.str_]
    preferences: NDArray[np.str_]
    angles_deg: Array

    def __len__(self) -> int:
        return len(self.people)

    def where(self, chosen: NDArray[np.bool_]) -> Self:
        """Those for which `chosen` (N,) holds."""
        return type(self)(self.people[chosen], self.actions[chosen], self.preferences[chosen], self.angles_deg[chosen])


def of_motion(motion: Motion, angles_rad: Array) -> Array:
    """The mean angles (N_PARTS, J) in degrees over the parts of a motion's phases, from those of its ticks (T, J)."""
    parts = [
        ticks.mean(axis=0)
        for phase in motion.phases
        for ticks in np.array_split(angles_rad[phase.start : phase.stop], PARTS[phase.name])
    ]
    return np.asarray(np.degrees(np.array(parts)))


def of_stream(times_s: Array, angles_deg: Array, cycle: Cycle) -> Array:
    """The mean angles (K, J) in degrees over the K parts of a cycle that are over, from a stream.

    times_s (T,): since the cycle began; angles_deg (T, J). A part of which nothing was measured is NaN. The duration
    of the phases is the cycle's: people who are faster or slower are compared with others at the same time.
    """
    growing = Growing(cycle, angles_deg.shape[1])
    growing.add(times_s, angles_deg)
    return growing.parts(times_s.max(initial=0.0))


class Growing:
    """A cycle's motion that is still being measured: sums over its parts, however fast the samples come."""

    def __init__(self, cycle: Cycle, joints: int) -> None:
        """joints: J, the number of angles of a sample."""
        self._ends_s = part_ends_s(cycle)
        self._total_deg = np.zeros((N_PARTS, joints))
        self._count = np.zeros((N_PARTS, joints), np.int64)

    def add(self, times_s: Array, angles_deg: Array) -> None:
        """Samples at times (T,) in s since the cycle began, in any order; those outside of it do not count.

        angles_deg (T, J): NaN where nothing was measured.
        """
        inside = (times_s >= 0) & (times_s < self._ends_s[-1])
        of_part = np.searchsorted(self._ends_s, times_s[inside], side="right")
        seen = np.isfinite(angles_deg[inside])
        np.add.at(self._total_deg, of_part, np.where(seen, angles_deg[inside], 0.0))
        np.add.at(self._count, of_part, seen)

    def parts(self, now_s: float) -> Array:
        """The mean angles (K, J) in degrees over the K parts that are over at this time since the cycle began."""
        over = int(np.searchsorted(self._ends_s, now_s + CLOCK_S, side="right"))
        total, count = self._total_deg[:over], self._count[:over]
        return np.asarray(np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0))


def part_ends_s(cycle: Cycle) -> Array:
    """When each part of a cycle is over, (N_PARTS,) in s since the cycle began."""
    durations = {"reach": cycle.reach_s, "work": cycle.work_s, "return": cycle.return_s}
    return np.cumsum(np.concatenate([np.full(PARTS[phase], durations[phase] / PARTS[phase]) for phase in PHASES]))


def measured(reactions: Sequence[Reaction], cycle: Cycle, error: CaptureError) -> Repetitions:
    """Repetitions of reactions as motion capture would see them: every repetition with errors of its own.

    A person's offsets are the same in all repetitions. Each stream of random numbers is keyed by person, action and
    preference, so that those of one do not depend on who else is there.
    """
    noise = error.noise_deg * np.linalg.cholesky(_noise_covariance(cycle, error.correlation_time_s))
    angles, labels = [], []
    for reaction in reactions:
        table = reaction.angles_rad().to_numpy()
        clean = of_motion(reaction.motion, table)
        offset = error.offset_deg * random_stream(error.seed, "offset", reaction.name.worker).standard_normal(
            clean.shape[1]
        )
        drawn = random_stream(error.seed, "noise", *reaction.name).standard_normal((error.repetitions, *clean.shape))
        angles.append(clean + offset + noise @ drawn)
        labels += [reaction.name] * error.repetitions
    people, actions, preferences = np.array(labels).T
    return Repetitions(people, actions, preferences, np.concatenate(angles))


def _noise_covariance(cycle: Cycle, correlation_time_s: float) -> Array:
    """Covariance (N_PARTS, N_PARTS) of the parts' means of a process of variance 1 and exponential correlation."""
    ends = part_ends_s(cycle)
    starts = np.concatenate([[0.0], ends[:-1]])
    shares = (np.arange(INSTANTS) + 0.5) / INSTANTS
    instants = (starts[:, None] + (ends - starts)[:, None] * shares).ravel()
    correlation = np.exp(-np.abs(instants[:, None] - instants) / correlation_time_s)
    return np.asarray(correlation.reshape(N_PARTS, INSTANTS, N_PARTS, INSTANTS).mean(axis=(1, 3)))

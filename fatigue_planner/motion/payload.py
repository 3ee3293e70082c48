"""What the hands carry or push against: masses held during phases, and forces over time."""

import itertools
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.core.errors import shortened
from fatigue_planner.core.settings import Settings
from fatigue_planner.motion.settings import PHASES, PhaseName, Side

Vector = NDArray[np.float64]


class CarriedMass(Settings):
    """A point mass at the centre of a fist during some phases."""

    kind: Literal["mass"]
    hand: Side
    mass_kg: float = Field(gt=0, le=50)
    during: tuple[PhaseName, ...] = Field(default=PHASES, min_length=1)


class TimedForce(Settings):
    """A force in N on the hand, at a time since the beginning of the cycle."""

    cycle_time_s: float = Field(ge=0, le=1800)
    x: float = Field(default=0, ge=-1000, le=1000)
    y: float = Field(default=0, ge=-1000, le=1000)
    z: float = Field(default=0, ge=-1000, le=1000)


class HandForce(Settings):
    """A force on the centre of a fist: linear between the times given, constant before and after.

    In the axes of the world (a weight of 40 N is z: -40) or of the hand, which turn with it.
    """

    kind: Literal["force"]
    hand: Side
    frame: Literal["world", "hand"]
    force_n: tuple[TimedForce, ...] = Field(min_length=1, max_length=5000)

    @model_validator(mode="after")
    def _check_times(self) -> Self:
        times = [force.cycle_time_s for force in self.force_n]
        if any(b <= a for a, b in itertools.pairwise(times)):
            raise ValueError(f"force_n: cycle_time_s = {shortened(times)}; the times must increase")
        return self

    def at(self, times_s: Vector) -> Vector:
        """The forces (T, 3) N at times (T,), in their own frame."""
        times = [force.cycle_time_s for force in self.force_n]
        columns = [np.interp(times_s, times, [getattr(force, axis) for force in self.force_n]) for axis in "xyz"]
        return np.column_stack(columns)


Load = CarriedMass | HandForce

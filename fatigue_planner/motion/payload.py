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


class FromFist(Settings):
    """A point from the centre of a fist, in the hand's axes: those of the hanging arm, which turn with the hand."""

    x: float = Field(default=0, ge=-1, le=1, description="Distance in m from the fist's centre towards the thumb.")
    y: float = Field(
        default=0,
        ge=-1,
        le=1,
        description="Distance in m from the fist's centre to the left of the hanging arm: out of the right palm.",
    )
    z: float = Field(
        default=0, ge=-1, le=1, description="Distance in m from the fist's centre along the hand, towards the wrist."
    )

    def vector(self) -> Vector:
        """The point as (3,) m."""
        return np.array([self.x, self.y, self.z])


class CarriedMass(Settings):
    """A point mass in a hand during some phases, at the centre of the fist or away from it."""

    kind: Literal["mass"] = Field(description="A mass that the hand carries.")
    hand: Side = Field(description="The hand that carries the mass.")
    mass_kg: float = Field(gt=0, le=50, description="Mass in kg, a point.")
    centre_of_mass_m: FromFist = Field(
        default=FromFist(),
        description="Where the point is, in m from the fist's centre in the hand's axes. Default: there.",
    )
    during: tuple[PhaseName, ...] = Field(
        default=PHASES, min_length=1, description="Phases in which the mass is carried."
    )


class TimedForce(Settings):
    """A force in N on the hand, at a time since the beginning of the cycle."""

    cycle_time_s: float = Field(ge=0, le=1800, description="Time in s since the beginning of the cycle.")
    x: float = Field(default=0, ge=-1000, le=1000, description="Force on the hand in N along the frame's x axis.")
    y: float = Field(default=0, ge=-1000, le=1000, description="Force on the hand in N along the frame's y axis.")
    z: float = Field(default=0, ge=-1000, le=1000, description="Force on the hand in N along the frame's z axis.")


class HandForce(Settings):
    """A force on the centre of a fist: linear between the times given, constant before and after.

    In the axes of the world (a weight of 40 N is z: -40) or of the hand, which turn with it.
    """

    kind: Literal["force"] = Field(description="A force that acts on the hand.")
    hand: Side = Field(description="The hand on which the force acts.")
    frame: Literal["world", "hand"] = Field(
        description="Axes of the force: the world's (x forward, y left, z up) or the hand's, which turn with it."
    )
    force_n: tuple[TimedForce, ...] = Field(
        min_length=1,
        max_length=5000,
        description="Forces in N at increasing times; linear in between, constant before and after.",
    )

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

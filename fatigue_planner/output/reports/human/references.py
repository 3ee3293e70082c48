"""Reference numbers of the literature, from data/references.yaml; every one names its source."""

from functools import cache
from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.human.model import Worker
from fatigue_planner.human.multibody import GRAVITY_MPS2

FILE = Path(__file__).parent / "data" / "references.yaml"

# Least and most.
Interval = tuple[float, float]
# The joints of the tables of torques (see `postures.py`).
LoadedJoint = Literal["back", "shoulder", "elbow", "wrist"]


class Source(Settings):
    """Where numbers come from, and whether they were read there (R), computed (C) or recalled (M)."""

    mark: Literal["R", "C", "M"]
    text: str


class SegmentGroup(Settings):
    """Bodies of the model whose mass the sources give as one, in % of body mass by source."""

    bodies: tuple[str, ...]
    rows: tuple[str, ...]
    percent: dict[str, float | dict[Sex, float]]


class Height(Settings):
    """A landmark: the origin of a body, or a length below it; shares of stature by source."""

    body: str
    below: str | None = None
    share: dict[str, float]
    measured: str | None = None


class MassAndHeight(Settings):
    """A segment of a standing body: share of mass, heights of its ends and place of its centre of mass."""

    mass: float
    lower: float
    upper: float
    from_lower: float


class MeasuredRange(Settings):
    """Ranges of motion by source, in degrees, of one degree of freedom or of several that add up."""

    freedoms: tuple[str, ...]
    ranges: dict[str, tuple[float | None, float | None]]


class ReferencePosture(Settings):
    """A posture at rest, and the torques expected in it, in N.m."""

    tool_mass_kg: float = Field(ge=0)
    angles_deg: dict[str, float]
    joints: tuple[LoadedJoint, ...]
    expected: dict[LoadedJoint, Interval] = Field(default_factory=dict)
    bands: dict[LoadedJoint, Interval] = Field(default_factory=dict)


class Target(Settings):
    """A place of the fist in the world, and the band of the torque it should cost, in N.m."""

    position_m: tuple[float, float, float]
    tool_mass_kg: float
    joint: LoadedJoint
    band: Interval


class MeasuredStrength(Settings):
    """Strengths of one source by entry (`lumbar_flexion:negative`) and sex."""

    unit: Literal["nm", "nm_per_kg", "share_of_weight_times_stature"]
    values: dict[str, dict[Sex, float]]

    def torque_nm(self, entry: str, worker: Worker) -> float | None:
        """The source's torque for a body like the worker's, or None if it has none."""
        value = self.values.get(entry, {}).get(worker.sex)
        if value is None:
            return None
        match self.unit:
            case "nm":
                return value
            case "nm_per_kg":
                return value * worker.mass_kg
            case "share_of_weight_times_stature":
                return value * worker.mass_kg * GRAVITY_MPS2 * worker.height_m


class Endurance(Settings):
    """Endurance time at a constant share f of the strength: factor * f ** exponent, in seconds.

    joint: whose rates the model has to compare with it; general: those of a joint without a curve of its own.
    """

    source: str
    joint: str
    factor: float
    exponent: float

    def time_s(self, share: float) -> float:
        """Endurance time at a share of the strength."""
        return float(self.factor * share**self.exponent)


class References(Settings):
    """Content of data/references.yaml."""

    sources: dict[str, Source]
    segment_masses: dict[str, SegmentGroup]
    heights: dict[str, Height]
    measured_subjects: tuple[dict[str, float], ...]
    winter_body: dict[str, MassAndHeight]
    ranges_of_motion: tuple[MeasuredRange, ...]
    postures: dict[str, ReferencePosture]
    targets: tuple[Target, ...]
    strengths: dict[str, MeasuredStrength]
    endurance: dict[str, Endurance]

    @model_validator(mode="after")
    def _check_sources(self) -> Self:
        named = {*self.strengths, *(row.source for row in self.endurance.values())}
        for group in self.segment_masses.values():
            named |= group.percent.keys()
        for height in self.heights.values():
            named |= height.share.keys()
        for row in self.ranges_of_motion:
            named |= row.ranges.keys()
        unknown = named - self.sources.keys()
        if unknown:
            raise ValueError(f"sources: {', '.join(sorted(unknown))} missing")
        return self


@cache
def references() -> References:
    """The reference numbers."""
    return load_data(FILE, References)

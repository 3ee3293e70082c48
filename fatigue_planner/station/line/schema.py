"""The content of a line's file: its stations, its crew and its shift."""

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from fatigue_planner.core.errors import listed
from fatigue_planner.core.settings import Name, Settings
from fatigue_planner.core.text import counted
from fatigue_planner.human.strength_sets import MAX_PATH_LENGTH
from fatigue_planner.station.schema import ShiftHours, StationWorker

MINUTES = 60
# What times in min may be off by rounding.
ROUNDING_MIN = 1e-6
MeasureName = Literal["acceptable_effort", "dose", "cumulative_strain_index"]


class LineStation(Settings):
    """A station of the line."""

    file: Annotated[str, Field(min_length=1, max_length=MAX_PATH_LENGTH)] = Field(
        description="The station's file, beside that of the line, or the name of one that ships with fatplan. Its "
        "workers and its shift do not count here."
    )
    cycles_per_hour: float | None = Field(
        default=None, gt=0, le=3600, description="Cycles in an hour of work, without unit. Default: by the file's takt."
    )


class CrewMember(StationWorker):
    """A worker of the line, and where he or she may not work."""

    not_at: tuple[Name, ...] = Field(
        default=(), max_length=12, description="Names of stations at which the worker may not work. Default: none."
    )


class Line(Settings):
    """A line of stations, each with one worker in every slot of the shift."""

    name: Name = Field(description="Name of the line; results go to a folder of this name.")
    stations: dict[Name, LineStation] = Field(
        min_length=1, max_length=12, description="Stations by name, in the order in which workers go on."
    )
    crew: dict[Name, CrewMember] = Field(
        min_length=1, max_length=12, description="Workers by a pseudonym, at least as many as stations."
    )
    shift: ShiftHours = Field(description="Length and breaks of the shift.")
    slots: int = Field(
        default=8, ge=1, le=8, description="How many slots, equally long, the working time is divided into."
    )
    forbidden: Literal["said", "left_out"] = Field(
        default="said",
        description="A worker at a station where a rule forbids even the best that he or she can do there. said: may "
        "work there, and that is said; left_out: does not.",
    )
    measure: MeasureName = Field(
        default="acceptable_effort",
        description="What is balanced. acceptable_effort: effort over the maximum acceptable effort of the joints; "
        "dose: damage over DUET's cut point; cumulative_strain_index: that of the hands over 10.",
    )

    @property
    def slot_s(self) -> float:
        """How long a slot is in s of work."""
        return (MINUTES * self.shift.hours - sum(one.minutes for one in self.shift.breaks)) * 60 / self.slots

    def slot_times(self) -> list[list[tuple[float, float]]]:
        """Of every slot the times of work in it, from when to when in min of the shift: a break may divide it."""
        begin, found = 0.0, list[list[tuple[float, float]]]([] for _ in range(self.slots))
        slot, left = 0, self.slot_s / 60
        for at_min, minutes in [*((one.at_min, one.minutes) for one in self.shift.breaks), (60 * self.shift.hours, 0)]:
            while at_min - begin > ROUNDING_MIN:
                end = min(begin + left, at_min)
                found[slot].append((begin, end))
                begin, left = end, left - (end - begin)
                if left <= ROUNDING_MIN and slot < self.slots - 1:
                    slot, left = slot + 1, self.slot_s / 60
            begin = at_min + minutes
        return found

    @model_validator(mode="after")
    def _check_across(self) -> Self:
        if faults := list(self._faults()):
            raise ValueError("\n".join(faults))
        return self

    def _faults(self) -> Iterator[str]:
        if len(self.crew) < len(self.stations):
            yield (
                f"crew: {counted(len(self.crew), 'worker')} cannot man {counted(len(self.stations), 'station')} all "
                "the time; each station has a worker in every slot"
            )
        if self.shift.other_work:
            yield "shift.other_work: is not for a line, whose stations are the other work"
        for name, worker in self.crew.items():
            if unknown := [each for each in worker.not_at if each not in self.stations]:
                yield f"crew.{name}.not_at: {listed(unknown)}: not among the stations {listed(self.stations)}"
        nobody = [name for name in self.stations if all(name in worker.not_at for worker in self.crew.values())]
        yield from (f"stations.{name}: nobody of the crew may work there (not_at)" for name in nobody)
        may = csr_array([[name not in worker.not_at for name in self.stations] for worker in self.crew.values()])
        manned = int((maximum_bipartite_matching(may, perm_type="row") >= 0).sum())
        if not nobody and manned < min(len(self.stations), len(self.crew)):
            yield (
                f"crew: by not_at, at most {manned} of {counted(len(self.stations), 'station')} can have a worker at "
                "the same time"
            )

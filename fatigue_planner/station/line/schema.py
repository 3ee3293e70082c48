"""The content of a line's file: its stations, its crew and its shift."""

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from fatigue_planner.core.errors import listed
from fatigue_planner.core.settings import Name, Settings
from fatigue_planner.human.strength_sets import MAX_PATH_LENGTH
from fatigue_planner.station.schema import ShiftHours, StationWorker

MINUTES = 60
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
    measure: MeasureName = Field(
        default="acceptable_effort",
        description="What is balanced. acceptable_effort: effort over the maximum acceptable effort of the joints; "
        "dose: damage over DUET's cut point; cumulative_strain_index: that of the hands over 10.",
    )

    @property
    def slot_s(self) -> float:
        """How long a slot is in s of work."""
        return (MINUTES * self.shift.hours - sum(one.minutes for one in self.shift.breaks)) * 60 / self.slots

    @model_validator(mode="after")
    def _check_across(self) -> Self:
        if faults := list(self._faults()):
            raise ValueError("\n".join(faults))
        return self

    def _faults(self) -> Iterator[str]:
        if len(self.crew) < len(self.stations):
            yield f"crew: {len(self.crew)} workers cannot man {len(self.stations)} stations all the time"
        if self.shift.other_work:
            yield "shift.other_work: is not for a line, whose stations are the other work"
        for name, worker in self.crew.items():
            if unknown := [each for each in worker.not_at if each not in self.stations]:
                yield f"crew.{name}.not_at: {listed(unknown)}: not among the stations {listed(self.stations)}"
        for name in self.stations:
            if all(name in worker.not_at for worker in self.crew.values()):
                yield f"stations.{name}: nobody of the crew may work there (not_at)"

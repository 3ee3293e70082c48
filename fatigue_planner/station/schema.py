"""The content of a station file: who works there, where, with what, how long. What is left out is unknown or usual."""

import math
import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from fatigue_planner.core.errors import listed, shortened
from fatigue_planner.core.settings import Name, Settings
from fatigue_planner.ergonomics.indicator import INDICATORS
from fatigue_planner.ergonomics.registry import KINDS
from fatigue_planner.ergonomics.stated import Circumstances, OtherWork
from fatigue_planner.human.anthropometry import Sex
from fatigue_planner.human.population import Population
from fatigue_planner.human.strength_sets import MAX_PATH_LENGTH
from fatigue_planner.motion.action import Orientation, Position
from fatigue_planner.motion.payload import FromFist
from fatigue_planner.motion.settings import Side
from fatigue_planner.robot.settings import RobotSettings
from fatigue_planner.station.limits import Limit

# Estimates from strengths alone that find most work with a raised arm too much; no standard sets their limits.
ONLY_WARN = ("acceptable_effort", "holding_time")
_SHIPPED: list[str] = [kind.model_fields["kind"].default for kind in KINDS]
BINDING = tuple(kind for kind in _SHIPPED if kind not in ONLY_WARN)

Way = Literal["arm", "back", "squat"]
WAYS: tuple[Way, ...] = ("arm", "back", "squat")
Hands = Literal["right", "left", "either", "other", "both"]

# How many places the operations of a cycle can be combined in, and how many motions there are to simulate.
MAX_COMBINATIONS, MAX_MOTIONS = 1000, 2000
# How far a place is at most in m, and how large a force in N, whichever way the worker faces.
FARTHEST_M, STRONGEST_N = 2.5, 1000.0
_MASS = re.compile(r"([0-9]+(?:\.[0-9]+)?) ?kg")
Percentile = Annotated[float, Field(ge=1, le=99)]


class StationWorker(Settings):
    """A worker: a percentile of stature, or a person who was measured."""

    sex: Sex = Field(description="Decides the distribution of stature, the proportions and the usual strength.")
    percentile: Percentile | None = Field(
        default=None,
        description="Percentile of stature, in per cent of the women or men of the population who are shorter, without "
        "unit: 5 is small, 95 is tall. Or give height_m.",
    )
    height_m: float | None = Field(
        default=None, ge=1.4, le=2.1, description="Stature without shoes, in m, of a person who was measured."
    )
    mass_kg: float | None = Field(
        default=None,
        ge=40,
        le=150,
        description="Body mass in kg. Default: the median mass of people of the same sex and stature.",
    )
    handedness: Side = Field(default="right", description="The hand that works where an operation says either.")
    strength_percentile: Percentile = Field(
        default=50.0,
        description="Percentile of strength in every joint at once, without unit: 5 is weak. Strength hardly follows "
        "stature, so it is said apart.",
    )
    strength: Annotated[str, Field(min_length=1, max_length=MAX_PATH_LENGTH)] | None = Field(
        default=None,
        description="Strengths of the average of such people in N.m: the name of a set that ships with fatplan, or a "
        "YAML file. Default: average_woman or average_man.",
    )

    @model_validator(mode="after")
    def _check_stature(self) -> Self:
        if (self.percentile is None) == (self.height_m is None):
            raise ValueError("give either percentile (of stature) or height_m (measured), such as percentile: 5")
        return self


class Force(Settings):
    """A force on a hand in world axes."""

    x: float = Field(default=0, ge=-1000, le=1000, description="Force on the hand in N, forward.")
    y: float = Field(default=0, ge=-1000, le=1000, description="Force on the hand in N, to the left.")
    z: float = Field(default=0, ge=-1000, le=1000, description="Force on the hand in N, upward; a push down is z: -40.")


class HandTool(Settings):
    """A tool, a part or a load: its mass in the fist and the force with which the work pushes back."""

    mass_kg: float = Field(ge=0, le=30, description="Mass in kg, a point in the hand; shared where both hands work.")
    centre_of_mass_m: FromFist = Field(
        default=FromFist(),
        description="Where its centre of mass is, in m from the centre of the right fist that holds it: x towards the "
        "thumb, y out of the palm, z towards the wrist; of the left fist in the mirror. Not where both hands work. "
        "Default: in the fist.",
    )
    force_n: Force | None = Field(
        default=None,
        description="Force in N with which the work pushes on the hand while it works; shared where both hands work. "
        "Default: none.",
    )


def _tool(value: Any) -> Any:
    """`1.2 kg` is a tool of this mass."""
    if isinstance(value, str):
        if not (mass := _MASS.fullmatch(value.strip())):
            raise ValueError(f"{shortened(value)}: a tool is its mass with the unit, 1.2 kg, or {{mass_kg: 1.2}}")
        return {"mass_kg": float(mass[1])}
    if isinstance(value, int | float):
        raise ValueError(f"{value} has no unit; write {value} kg or {{mass_kg: {value}}}")
    return value


class Place(Position):
    """Where the hand works: x forward, y left, z up, in m, from the ground between the feet."""

    orientation_deg: Orientation | None = Field(
        default=None,
        description="How the hand is held, in degrees; {y: -90} is a fist that points forward. Default: as it likes.",
    )
    tool: Name | None = Field(default=None, description="The tool that is used at this place instead of another.")
    map: Name | None = Field(
        default=None,
        description="The map of the page on which the place is drawn. Default: none; of a point of a grid, the grid's.",
    )


def _names(value: Any) -> Any:
    """One name is a list of one."""
    return (value,) if isinstance(value, str) else value


class StationOperation(Circumstances):
    """Something that has to be done in every cycle, at one of its places."""

    places: Annotated[tuple[Name, ...], BeforeValidator(_names)] = Field(
        min_length=1,
        max_length=100,
        description="Name of the place, or a list of names of places at which the operation could be done.",
    )
    seconds: float = Field(ge=0.1, le=600, description="How long the hand works at the place, in s, the way excluded.")
    hand: Hands = Field(
        default="either",
        description="The hand that works. either: the worker's better one; other: the one that is not; both: both "
        "together, grip_width_m apart.",
    )
    tool: Name | None = Field(default=None, description="The tool that is held, by its name. Default: none.")
    grip_width_m: float = Field(
        default=0.3, ge=0.1, le=1, description="Distance in m between the fists where both hands work."
    )
    times_per_cycle: int = Field(
        default=1, ge=1, le=100, description="How often the operation is done in a cycle, without unit."
    )


class StationCycle(Settings):
    """The takt: how long a cycle lasts, and what of it is ways."""

    duration_s: float = Field(
        gt=0, le=1800, description="Time in s from one beginning of the cycle to the next: the takt."
    )
    reach_s: float = Field(default=3.0, ge=0.5, le=60, description="Time in s from hanging arms to a place.")
    return_s: float = Field(default=4.0, ge=0.5, le=60, description="Time in s from a place back to hanging arms.")


class Break(Settings):
    """A break of the shift."""

    at_min: float = Field(ge=0, le=1440, description="When the break begins, in minutes of the shift, without unit.")
    minutes: float = Field(gt=0, le=480, description="How long the break is, in minutes, without unit.")


class ShiftHours(Settings):
    """The shift; it decides duration classes of scores, not the simulation."""

    hours: float = Field(gt=0, le=24, description="Length of the shift in hours, breaks included, without unit.")
    breaks: tuple[Break, ...] = Field(default=(), max_length=50, description="The breaks, in their order.")
    other_work: dict[Name, OtherWork] = Field(
        default_factory=dict,
        max_length=20,
        description="What the workers do at other stations before or after, by name: job rotation, for the cumulative "
        "strain index. Default: nothing.",
    )

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        end = 0.0
        for one in self.breaks:
            if one.at_min < end or one.at_min + one.minutes > 60 * self.hours:
                raise ValueError(
                    f"breaks: the one at {one.at_min:g} min begins before the one before it ends ({end:g} min), or "
                    f"ends after the shift ({60 * self.hours:g} min)"
                )
            end = one.at_min + one.minutes
        if sum(one.minutes for one in self.breaks) >= 60 * self.hours:
            raise ValueError(f"breaks: they leave nothing of the {self.hours:g} h to work in")
        return self


class About(Settings):
    """What a page that is handed on says of its making; it decides nothing."""

    company: str = Field(default="", max_length=200, description="The company, for the page.")
    plant: str = Field(default="", max_length=200, description="Plant, line and place, for the page.")
    revision: str = Field(default="", max_length=200, description="Revision of the station, for the page.")
    assessor: str = Field(default="", max_length=200, description="Who assesses, for the page.")
    date: str = Field(default="", max_length=40, description="The day of the assessment, for the page.")


class Station(Settings):
    """Everything about a station: workers, places, operations and the cycle; the rest has a default."""

    name: Name = Field(description="Name of the station; results go to a folder of this name.")
    about: About = Field(default=About(), description="Company, plant, assessor and date, for the page.")
    population: Population | None = Field(
        default=None,
        description="Means and standard deviations of your own people. Default: ANSUR II, soldiers of the US in 2012.",
    )
    workers: dict[Name, StationWorker] = Field(min_length=1, max_length=20, description="Workers by name.")
    tools: dict[Name, Annotated[HandTool, BeforeValidator(_tool)]] = Field(
        default_factory=dict, max_length=100, description="Tools and parts by name: a mass such as 1.2 kg, or more."
    )
    places: dict[Name, Place] = Field(min_length=1, max_length=100, description="Places of the hand by name.")
    operations: dict[Name, StationOperation] = Field(
        min_length=1, max_length=20, description="What has to be done in every cycle, by name, in this order."
    )
    cycle: StationCycle = Field(description="How long a cycle lasts.")
    ways: tuple[Way, ...] = Field(
        default=WAYS,
        min_length=1,
        description="How the worker may work. arm: trunk upright; back: upper arm hanging, trunk bent; squat: trunk "
        "and pelvis upright, knees bent.",
    )
    feet: Literal["free", "fixed"] = Field(
        default="free",
        description="How the worker stands. free: the feet are turned to every place, so that it is straight ahead, at "
        "its distance and height; fixed: the feet point along x, and who has to reach aside twists.",
    )
    shoes_m: float = Field(default=0.025, ge=0, le=0.1, description="Thickness in m of the soles of the shoes.")
    binding: tuple[str, ...] = Field(
        default=BINDING,
        max_length=100,
        description="Indicators that exclude a place where they find it not acceptable; the others only warn. Default: "
        "all but acceptable_effort and holding_time, whose limits no standard sets.",
    )
    limits: tuple[Limit, ...] = Field(
        default=(), max_length=20, description="What no worker may be asked for; it excludes places and ways."
    )
    robot: RobotSettings | None = Field(
        default=None,
        description="The robot that presents the object at the places. Where it cannot, or comes too near to a worker, "
        "is left out of what is recommended and planned. hold.direction is turned with a worker who faces the place. "
        "Default: none.",
    )
    shift: ShiftHours | None = Field(default=None, description="Length and breaks of the shift. Default: not known.")

    @field_validator("ways")
    @classmethod
    def _check_ways(cls, ways: tuple[Way, ...]) -> tuple[Way, ...]:
        if len(set(ways)) < len(ways):
            raise ValueError("names a way twice")
        return ways

    @model_validator(mode="after")
    def _check_across(self) -> Self:
        if faults := [
            *self._name_faults(),
            *self._map_faults(),
            *self._lever_faults(),
            *self._binding_faults(),
            *self._population_faults(),
            *self._time_faults(),
            *self._size_faults(),
        ]:
            raise ValueError("\n".join(faults))
        return self

    def _name_faults(self) -> Iterator[str]:
        for name, operation in self.operations.items():
            key = f"operations.{name}"
            for place in operation.places:
                if place not in self.places:
                    yield f"{key}.places: {place!r} is not one of {listed(self.places)}"
            if len(set(operation.places)) < len(operation.places):
                yield f"{key}.places: names a place twice"
            yield from self._tool_faults(f"{key}.tool", operation.tool)
        for name, at in self.places.items():
            yield from self._tool_faults(f"places.{name}.tool", at.tool)
            if (away_m := math.hypot(at.x, at.y)) > FARTHEST_M:
                yield f"places.{name}: is {away_m:.2f} m from between the feet; at most {FARTHEST_M:g} m"
        for name, tool in self.tools.items():
            force = tool.force_n or Force()
            if (force_n := math.hypot(force.x, force.y, force.z)) > STRONGEST_N:
                yield f"tools.{name}.force_n: is {force_n:.0f} N; at most {STRONGEST_N:g} N"

    def _lever_faults(self) -> Iterator[str]:
        for name, operation in self.operations.items():
            for place in operation.places if operation.hand == "both" else ():
                tool = self.tool_at(name, place) if place in self.places else None
                if tool in self.tools and self.tools[tool].centre_of_mass_m != FromFist():
                    yield (
                        f"tools.{tool}.centre_of_mass_m: {name} holds it with both hands, so its centre is between the "
                        "fists; leave it out"
                    )

    def _map_faults(self) -> Iterator[str]:
        drawn: dict[tuple[Any, ...], str] = {}
        for name, at in self.places.items():
            if at.map is not None and (other := drawn.setdefault((at.map, at.x, at.y, at.z), name)) != name:
                yield f"places.{name}.map: {other} is at the same point of map {at.map}, which shows one place there"

    def _binding_faults(self) -> Iterator[str]:
        if unknown := [kind for kind in self.binding if kind not in INDICATORS.kinds()]:
            yield f"binding: {listed(unknown)}: not among the indicators {listed(INDICATORS.kinds())}"

    def _tool_faults(self, key: str, tool: str | None) -> Iterator[str]:
        if tool is not None and tool not in self.tools:
            yield f"{key}: {tool!r} is not one of the tools: {listed(self.tools) or 'there are none'}"

    def _population_faults(self) -> Iterator[str]:
        for name, worker in self.workers.items():
            if self.population and worker.percentile is not None and not self.population.people(worker.sex):
                yield f"workers.{name}.percentile: population.{worker.sex} is not given"

    def _time_faults(self) -> Iterator[str]:
        busy_s = self.busy_s()
        if busy_s > self.cycle.duration_s + 1e-9:
            yield (
                f"cycle.duration_s = {self.cycle.duration_s:g}: the operations take {busy_s:g} s with their ways "
                f"({self.cycle.reach_s:g} s there and {self.cycle.return_s:g} s back each time); give the cycle more "
                "time, or cycle.reach_s and return_s less"
            )

    def _size_faults(self) -> Iterator[str]:
        combinations, motions = 1, 0
        for operation in self.operations.values():
            combinations *= len(operation.places)
            motions += len(operation.places) * len(self.workers) * len(self.ways)
        if combinations > MAX_COMBINATIONS:
            yield f"operations: their places can be combined in {combinations} ways; at most {MAX_COMBINATIONS}"
        if motions > MAX_MOTIONS:
            yield f"operations: with all workers, places and ways {motions} motions; at most {MAX_MOTIONS}"

    def busy_s(self) -> float:
        """How long all operations of a cycle take together, with their ways, in s."""
        return sum(self.operation_s(name) * each.times_per_cycle for name, each in self.operations.items())

    def operation_s(self, name: str) -> float:
        """How long an operation takes once, with its ways, in s."""
        return self.cycle.reach_s + self.operations[name].seconds + self.cycle.return_s

    def tool_at(self, operation: str, place: str) -> str | None:
        """The name of the tool that an operation needs at a place."""
        return self.places[place].tool or self.operations[operation].tool

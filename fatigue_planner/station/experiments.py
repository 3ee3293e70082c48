"""From a station to experiments of the usual kind, one for every operation and hand: everything works on them."""

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.core.settings import MAX_NAME_LENGTH
from fatigue_planner.experiment.defaults import usual_preferences
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.model import Worker
from fatigue_planner.motion.action import Action, HandGoal, Orientation, Position
from fatigue_planner.motion.payload import CarriedMass, FromFist, HandForce, Load, TimedForce
from fatigue_planner.motion.settings import Accuracy, Controller, Cycle, Side, Stiffnesses
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.motion.tasks.segment_upright import SegmentUpright
from fatigue_planner.station.schema import HandTool, Place, Station, StationOperation
from fatigue_planner.station.workers import worker_of

Vector = NDArray[np.float64]

SIDES: tuple[Side, ...] = ("right", "left")
# Half the ticks of an experiment, with the gain of the hand that they allow; what it changes: docs/deviations.md.
TIME_STEP_S = 0.02
CONTROLLER = Controller(time_step_s=TIME_STEP_S, stiffness_per_s2=Stiffnesses(hand=1000.0))
# Nobody places a hand to the centimetre, a sole that slides by 5 mm changes nothing that is judged, and the balance of
# power is of first order: twice the step, twice the error.
ACCURACY = Accuracy(hand_error_m=0.02, foot_displacement_m=0.005, energy_error_share=0.02)
# Over which a force on the hand comes and goes, in s.
RISE_S = 0.1


@dataclass(frozen=True)
class Part:
    """An operation of a station with certain hands: an experiment whose actions are places and preferences are ways."""

    station: Station
    operation: str
    hands: tuple[Side, ...]
    workers: tuple[str, ...]

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment, with all places."""
        return experiment_of(self, {name: worker_of(self.station, name) for name in self.workers})


def parts_of(station: Station) -> list[Part]:
    """The operations in their order, each once for all workers who do it with the same hands."""
    found = []
    for name, operation in station.operations.items():
        groups: dict[tuple[Side, ...], list[str]] = {}
        for worker in station.workers:
            groups.setdefault(hands_of(station, operation, worker), []).append(worker)
        found += [Part(station, name, hands, tuple(workers)) for hands, workers in groups.items()]
    return found


def hands_of(station: Station, operation: StationOperation, worker: str) -> tuple[Side, ...]:
    """The hands with which a worker does an operation."""
    match operation.hand:
        case "both":
            return SIDES
        case "either":
            return (station.workers[worker].handedness,)
        case "other":
            return ("left",) if station.workers[worker].handedness == "right" else ("right",)
        case side:
            return (side,)


def experiment_of(part: Part, workers: Mapping[str, Worker]) -> Experiment:
    """The experiment of a part with these workers."""
    station, operation = part.station, part.station.operations[part.operation]
    actions = {place: action_of(station, operation, place, part.hands) for place in operation.places}
    cycle = Cycle(reach_s=station.cycle.reach_s, work_s=operation.seconds, return_s=station.cycle.return_s)
    return Experiment(
        name=_short(f"{station.name}_{part.operation}_{'both' if len(part.hands) > 1 else part.hands[0]}"),
        human="natural",
        workers=dict(workers),
        cycle=cycle,
        actions=actions,
        preferences=ways_of(station, actions),
        controller=CONTROLLER,
        accuracy=ACCURACY,
    )


def ways_of(station: Station, actions: Mapping[str, Action]) -> dict[str, Preference]:
    """The ways of working as motion preferences: the usual arm and back, and a squat."""
    upright = (SegmentUpright(kind="segment_upright", segment=part, weight=10.0) for part in ("thorax", "pelvis"))
    known = usual_preferences({"actions": actions}) | {"squat": Preference(tasks=tuple(upright))}
    return {way: known[way] for way in station.ways}


def action_of(station: Station, operation: StationOperation, place: str, hands: tuple[Side, ...]) -> Action:
    """What the hands do at a place: where they are held, and what they bear.

    Shoes raise the worker, so places are lower by their soles. A worker whose feet are free faces the place; who then
    works with the left hand because it is the better one, or because it is not, does so in the mirror.
    """
    view = View.of(station, place, mirrored=hands == ("left",) and operation.hand in ("either", "other"))
    at, apart = station.places[place], operation.grip_width_m / 2 if len(hands) > 1 else 0.0
    goals = {f"{side}_hand": _goal(station, at, view, apart if side == "left" else -apart) for side in hands}
    named = at.tool or operation.tool
    loads = _loads(station, operation, station.tools[named], hands, view) if named else ()
    return Action(loads=loads, **goals)


@dataclass(frozen=True)
class View:
    """The axes of a worker whose feet are turned by an angle in rad, in the mirror or not."""

    turned_rad: float
    mirrored: bool

    @classmethod
    def of(cls, station: Station, place: str, mirrored: bool) -> Self:
        """That of a worker at a place: straight ahead if the feet are free."""
        at = station.places[place]
        return cls(math.atan2(at.y, at.x), mirrored) if station.feet == "free" else cls(0.0, False)

    def vector(self, world: Vector) -> Vector:
        """A vector (3,) of the station in the worker's axes."""
        turned = np.asarray(pin.rpy.rpyToMatrix(0.0, 0.0, -self.turned_rad) @ world)
        return np.array([1.0, -1.0, 1.0]) * turned if self.mirrored else turned

    def orientation(self, world: Orientation) -> Orientation:
        """An orientation of the station in the worker's axes."""
        if self.turned_rad == 0 and not self.mirrored:
            return world
        rotation = pin.rpy.rpyToMatrix(0.0, 0.0, -self.turned_rad) @ world.rotation()
        x, y, z = np.degrees(pin.rpy.matrixToRpy(rotation)).round(4).tolist()
        return Orientation(x=-x, y=y, z=-z) if self.mirrored else Orientation(x=x, y=y, z=z)


def _goal(station: Station, at: Place, view: View, aside_m: float) -> HandGoal:
    x, y, z = (view.vector(at.vector()) + np.array([0.0, aside_m, -station.shoes_m])).round(4).tolist()
    turn = None if at.orientation_deg is None else view.orientation(at.orientation_deg)
    return HandGoal(position_m=Position(x=x, y=y + 0.0, z=max(z, 0.0)), orientation_deg=turn)


def _loads(
    station: Station, operation: StationOperation, tool: HandTool, hands: tuple[Side, ...], view: View
) -> tuple[Load, ...]:
    """Mass and force of a tool in every hand that holds it, shared alike."""
    found: list[Load] = []
    begin, share = station.cycle.reach_s, 1 / len(hands)
    end, rise = begin + operation.seconds, min(RISE_S, operation.seconds / 4)
    for side in hands:
        if tool.mass_kg > 0:
            x, y, z = tool.centre_of_mass_m.vector().tolist()
            at = FromFist(x=x, y=y if side == "right" else -y, z=z)
            found.append(CarriedMass(kind="mass", hand=side, mass_kg=tool.mass_kg * share, centre_of_mass_m=at))
        if tool.force_n is not None:
            whole = np.array([tool.force_n.x, tool.force_n.y, tool.force_n.z])
            force = share * replace(view, mirrored=False).vector(whole)  # the work pushes no other way for anybody
            full = dict(zip("xyz", (force.round(4) + 0.0).tolist(), strict=True))
            course = ((begin, False), (begin + rise, True), (end - rise, True), (end, False))
            points = tuple(TimedForce(cycle_time_s=time, **(full if on else {})) for time, on in course)
            found.append(HandForce(kind="force", hand=side, frame="world", force_n=points))
    return tuple(found)


def _short(name: str) -> str:
    """A name as it is, or its beginning and a digest of all of it."""
    if len(name) <= MAX_NAME_LENGTH:
        return name
    return f"{name[: MAX_NAME_LENGTH - 9]}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"

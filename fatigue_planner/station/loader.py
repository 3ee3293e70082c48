"""From a file to a Station, or one clear message."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fatigue_planner.core.errors import DataFileError, ExperimentError
from fatigue_planner.core.file_kinds import FileKind, mapping_of_kind
from fatigue_planner.core.files import find_shipped
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.error_messages import error_lines, joined_errors
from fatigue_planner.fatigue.parameters import FatigueSettings, fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import build_human
from fatigue_planner.robot.arm import arm_named
from fatigue_planner.station.experiments import TIME_STEP_S
from fatigue_planner.station.place_grid import expand_place_grids
from fatigue_planner.station.schema import Station
from fatigue_planner.station.workers import worker_of

# What a number of time steps may be off a whole one by rounding.
WHOLE_STEPS = 1e-6
# What a station says in other words than an experiment.
AS_A_STATION = (
    "actions: belong to an experiment, between which a robot chooses. A station has places, and operations that are "
    "all done in every cycle, each at one of its places: places: {{{place}: {{x: {x}, y: {y}, z: {z}}}}} and "
    "operations: {{work: {{places: [{names}], seconds: 25}}}}."
)
EXAMPLE = ("overhead", {"x": 0.35, "y": -0.15, "z": 1.85})


def load_station(path: Path) -> Station:
    """The station of a file, or one that ships with fatplan by its name, checked completely.

    Raises ExperimentError: file, key, value, what is allowed; all errors of form at once, or else all of meaning.
    """
    path = find_shipped(path)
    content = read_yaml(path, ExperimentError)
    if not (isinstance(content, dict) and isinstance(content.get("actions"), dict)):
        content = mapping_of_kind(path, content, FileKind.STATION, ExperimentError)
    station = parse_station(content, str(path))
    if faults := list(station_faults(station)):
        raise ExperimentError(joined_errors(str(path), faults))
    return station


def parse_station(content: Mapping[str, Any], source: str) -> Station:
    """The station of a file's content, checked in form; `source` is its name. Raises ExperimentError: all errors."""
    own = {key: value for key, value in content.items() if key != "actions"}
    lines = [_as_a_station(content["actions"])] if "actions" in content else []
    own, grid_faults = expand_place_grids(own)
    if grid_faults:
        raise ExperimentError(joined_errors(source, grid_faults))
    try:
        station = Station.model_validate(own, strict=True)
    except ValidationError as error:
        missing = ("operations: is missing.", "places: is missing.") if lines else ()
        lines += [line for line in error_lines(error, Station) if line not in missing]
    if lines:
        raise ExperimentError(joined_errors(source, lines))
    return station


def _as_a_station(actions: Any) -> str:
    """How what an experiment calls actions is said of a station, with the numbers of the first."""
    places = {
        name: goal["position_m"]
        for name, action in (actions.items() if isinstance(actions, dict) else ())
        for goal in (action.get("right_hand") or action.get("left_hand") if isinstance(action, dict) else None,)
        if isinstance(goal, dict) and isinstance(goal.get("position_m"), dict)
    }
    place, point = next(iter(places.items()), EXAMPLE)
    axes = {axis: point.get(axis, EXAMPLE[1][axis]) for axis in EXAMPLE[1]}
    return AS_A_STATION.format(place=place, names=", ".join(places or [place]), **axes)


def station_faults(station: Station) -> Iterator[str]:
    """What the types of the schema cannot say."""
    for name in station.workers:
        try:
            worker = worker_of(station, name)
            build_human(worker)
            fatigue_parameters(FatigueSettings(), maximum_torque(worker.strength))
        except DataFileError as error:
            yield f"workers.{name}: {error}"
    if station.robot is not None:
        try:
            arm_named(station.robot.arm, station.robot.link_radius_m)
        except ExperimentError as error:
            yield str(error)
    times = {f"cycle.{key}": getattr(station.cycle, key) for key in ("duration_s", "reach_s", "return_s")}
    times |= {f"operations.{name}.seconds": each.seconds for name, each in station.operations.items()}
    for key, seconds in times.items():
        if abs(seconds / TIME_STEP_S - round(seconds / TIME_STEP_S)) > WHOLE_STEPS:
            yield f"{key} = {seconds:g}: should be a multiple of {TIME_STEP_S:g} s, the time step of the simulation."

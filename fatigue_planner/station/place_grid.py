"""Grids of places: a place whose coordinates are ranges stands for one place per point, a map of where work is good."""

import itertools
from collections.abc import Iterator, Mapping
from typing import Any

from fatigue_planner.core.settings import MAX_NAME_LENGTH
from fatigue_planner.experiment.error_messages import dotted
from fatigue_planner.experiment.pose_grid import AXES, GridError, point_name, range_of

# As many as an operation can choose between.
MAX_POINTS = 100


def expand_place_grids(content: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The content of a station file with every grid of places written out, and what is wrong with grids.

    Where coordinates of a place are ranges {from, to, count}, it becomes one place per point, named after it:
    rack_x0.4_z1.2 (m for minus), on the map of its name; operations that name the grid choose between all of them. A
    faulty grid is left as it is.
    """
    places = content.get("places")
    if not isinstance(places, dict):
        return dict(content), []
    grids: dict[str, dict[str, Any]] = {}
    faults: list[str] = []
    taken = set(places)
    for name, place in places.items():
        ranges = {axis: place[axis] for axis in AXES if isinstance(place, dict) and isinstance(place.get(axis), dict)}
        if ranges:
            found = list(_points(name, place, ranges, faults))
            if met := next((label for label, _ in found if label in taken), None):
                faults.append(f"{dotted(['places', name])}: its grid makes {met}, a name that another place has.")
            elif found:
                grids[name] = dict(found)
                taken |= grids[name].keys()
    written = {key: value for name, place in places.items() for key, value in grids.get(name, {name: place}).items()}
    return {**content, "places": written, **_operations(content.get("operations"), grids)}, faults


def _points(
    name: str, place: Mapping[str, Any], ranges: Mapping[str, Any], faults: list[str]
) -> Iterator[tuple[str, dict[str, Any]]]:
    values = {}
    for axis, value in ranges.items():
        key = dotted(["places", name, axis])
        try:
            values[axis] = range_of(key, value).values()
        except GridError as error:
            faults += error.args
    if len(values) < len(ranges):
        return
    points = list(itertools.product(*values.values()))
    longest = name + "".join(f"_{axis}m0.00000" for axis in values)
    if len(points) > MAX_POINTS or len(longest) > MAX_NAME_LENGTH:
        faults.append(
            f"{dotted(['places', name])}: its grid has {len(points)} points, and names of up to {len(longest)} "
            f"letters; allowed are {MAX_POINTS} and {MAX_NAME_LENGTH}."
        )
        return
    for point in points:
        at = dict(zip(values, point, strict=True))
        yield point_name(name, at), {"map": name, **place, **at}


def _operations(operations: Any, grids: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The operations with all points of the grids that they name."""
    if not isinstance(operations, dict) or not grids:
        return {}
    written = {}
    for name, operation in operations.items():
        named = operation.get("places") if isinstance(operation, dict) else None
        if isinstance(named, str):
            named = (named,)
        if isinstance(named, tuple):
            every = tuple(point for each in named for point in (grids.get(each, (each,))))
            operation = {**operation, "places": every}  # noqa: PLW2901 - the same with its grids written out
        written[name] = operation
    return {"operations": written}

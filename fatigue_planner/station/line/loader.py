"""From a line's file to a line with its stations, or one clear message."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.file_kinds import FileKind, mapping_of_kind
from fatigue_planner.core.files import file_named_in, find_shipped
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.error_messages import joined_errors
from fatigue_planner.experiment.loader import parse_settings
from fatigue_planner.station.experiments import TIME_STEP_S
from fatigue_planner.station.line.schema import Line, LineStation
from fatigue_planner.station.loader import WHOLE_STEPS, load_station, parse_station, station_faults
from fatigue_planner.station.schema import Station, StationWorker

HOUR_S = 3600.0


@dataclass(frozen=True)
class LoadedLine:
    """A line; stations: by name, each in the pace of the line, without a shift, with those of the crew who may work
    there; cycles_s: by name the pace.
    """

    line: Line
    stations: dict[str, Station]
    cycles_s: dict[str, float]

    def cycle_s(self, station: str) -> float:
        """From one beginning of a cycle to the next at the pace of the line.

        What judges a station's cycle has it rounded up to a whole time step.
        """
        return self.cycles_s[station]


def load_line(path: Path) -> LoadedLine:
    """The line of a file, checked completely, with its stations.

    Raises ExperimentError: file, key, value, what is allowed; also of a station's file.
    """
    path = find_shipped(path)
    content = read_yaml(path, ExperimentError)
    content = mapping_of_kind(path, content, FileKind.LINE, ExperimentError)
    line = parse_settings(Line, content, str(path), ExperimentError)
    stations, cycles_s = {}, {}
    for name, said in line.stations.items():
        file = file_named_in(path, f"stations.{name}.file", said.file)
        cycles_s[name], own = _in_pace(load_station(file), said, f"{path}: stations.{name}")
        own["workers"] = {
            worker: {key: getattr(member, key) for key in StationWorker.model_fields if key in member.model_fields_set}
            for worker, member in line.crew.items()
            if name not in member.not_at
        }
        stations[name] = parse_station(own, f"{path}: stations.{name} with the crew")
    if faults := list(_faults(stations)):
        raise ExperimentError(joined_errors(str(path), faults))
    return LoadedLine(line, stations, cycles_s)


def _in_pace(station: Station, said: LineStation, source: str) -> tuple[float, dict[str, Any]]:
    """The length of a station's cycle at the pace of the line in s, and what its file says of the rest."""
    own = station.model_dump(exclude_unset=True)
    own.pop("shift", None)
    if said.cycles_per_hour is None:
        return station.cycle.duration_s, own
    cycle_s, busy_s = HOUR_S / said.cycles_per_hour, station.busy_s()
    if cycle_s < busy_s * (1 - 1e-9):
        raise ExperimentError(
            f"{source}.cycles_per_hour = {said.cycles_per_hour:g}: the operations take {busy_s:g} s with their ways; "
            f"at most {HOUR_S / busy_s:.4g}"
        )
    steps = math.ceil(cycle_s / TIME_STEP_S - WHOLE_STEPS)
    own["cycle"] |= {"duration_s": round(steps * TIME_STEP_S, 6)}
    return cycle_s, own


def _faults(stations: Mapping[str, Station]) -> Iterator[str]:
    seen: set[str] = set()
    first, *others = stations
    for name in others:
        if stations[name].population != stations[first].population:
            yield (
                f"stations.{name}.file: its population is not that of {first}; a percentile, or the mass that goes "
                "with a height, would be another there"
            )
    for station in stations.values():
        for fault in station_faults(station):
            if fault.startswith("workers.") and fault not in seen:
                seen.add(fault)
                yield fault.replace("workers.", "crew.", 1)

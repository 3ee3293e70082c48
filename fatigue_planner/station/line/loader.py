"""From a line's file to a line with its stations, or one clear message."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.files import file_named_in, find_shipped
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.error_messages import joined_errors
from fatigue_planner.experiment.loader import parse_settings
from fatigue_planner.station.line.schema import Line
from fatigue_planner.station.loader import load_station, parse_station, station_faults
from fatigue_planner.station.schema import Station, StationWorker

HOUR_S = 3600.0


@dataclass(frozen=True)
class LoadedLine:
    """A line; stations: by name, each with the line's crew as its workers and without a shift."""

    line: Line
    stations: dict[str, Station]

    def cycle_s(self, station: str) -> float:
        """From one beginning of a cycle to the next at the pace of the line."""
        often = self.line.stations[station].cycles_per_hour
        return self.stations[station].cycle.duration_s if often is None else HOUR_S / often


def load_line(path: Path) -> LoadedLine:
    """The line of a file, checked completely, with its stations.

    Raises ExperimentError: file, key, value, what is allowed; also of a station's file.
    """
    path = find_shipped(path)
    content = read_yaml(path, ExperimentError)
    if not isinstance(content, dict):
        raise ExperimentError(f"{path}: is not a mapping of settings; docs/rotation.md explains the keys of a line.")
    line = parse_settings(Line, content, str(path), ExperimentError)
    crew = {
        name: {key: getattr(worker, key) for key in StationWorker.model_fields if key in worker.model_fields_set}
        for name, worker in line.crew.items()
    }
    stations = {}
    for name, said in line.stations.items():
        file = file_named_in(path, f"stations.{name}.file", said.file)
        own = load_station(file).model_dump(exclude_unset=True) | {"workers": crew}
        own.pop("shift", None)
        stations[name] = parse_station(own, f"{path}: stations.{name} with the crew")
    loaded = LoadedLine(line, stations)
    if faults := list(_faults(loaded)):
        raise ExperimentError(joined_errors(str(path), faults))
    return loaded


def _faults(loaded: LoadedLine) -> Iterator[str]:
    seen: set[str] = set()
    for name, station in loaded.stations.items():
        for fault in station_faults(station):
            if fault.startswith("workers.") and fault not in seen:
                seen.add(fault)
                yield fault.replace("workers.", "crew.", 1)
        if loaded.cycle_s(name) < station.busy_s() * (1 - 1e-9):
            often = loaded.line.stations[name].cycles_per_hour
            yield (
                f"stations.{name}.cycles_per_hour = {often:g}: the operations take {station.busy_s():g} s with their "
                f"ways; at most {HOUR_S / station.busy_s():.4g}"
            )

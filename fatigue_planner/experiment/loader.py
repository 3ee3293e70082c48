"""From a file to an Experiment, or one clear message."""

import difflib
from collections.abc import Iterator
from pathlib import Path

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from fatigue_planner.errors import DataFileError, ExperimentError
from fatigue_planner.experiment.feasibility import check_meaning
from fatigue_planner.experiment.grids import expand_grids
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.settings import Settings
from fatigue_planner.yaml_reader import read_yaml


def load_experiment(path: Path) -> Experiment:
    """The experiment of a file, checked completely.

    Raises ExperimentError: file, key, value, what is allowed; all faults of form at once, then the first
    of meaning.
    """
    content = read_yaml(path, ExperimentError)
    if not isinstance(content, dict):
        raise ExperimentError(f"{path}: is not a mapping of settings; see experiments/paper.yaml for an example.")
    try:
        experiment = Experiment.model_validate(expand_grids(content), strict=True)
    except ValidationError as error:
        faults = dict.fromkeys(_describe(fault) for fault in error.errors())
        raise ExperimentError("\n".join(f"{path}: {fault}" for fault in faults)) from error
    except ExperimentError as error:
        raise ExperimentError(f"{path}: {error}") from error
    try:
        check_meaning(experiment)
    except DataFileError as error:
        raise ExperimentError(f"{path}: {error}") from error
    return experiment


def _describe(fault: ErrorDetails) -> str:
    place = _place(fault["loc"])
    value = fault["input"]
    match fault["type"]:
        case "extra_forbidden":
            return f"{place}: unknown key{_did_you_mean(str(fault['loc'][-1]))}"
        case "missing":
            return f"{place}: is missing."
        case "value_error":
            return f"{place}: {fault['ctx']['error']}." if fault["loc"] else f"{fault['ctx']['error']}."
        case _:
            shown = f" = {value!r}" if isinstance(value, (str, int, float, bool, type(None))) else ""
            return f"{place}{shown}: {fault['msg'][0].lower()}{fault['msg'][1:]}."


def _place(location: tuple[int | str, ...]) -> str:
    """The path of a key; behind a name with a `kind` pydantic adds the kind, which the file has not."""
    parts = [str(part) for part in location]
    if parts[:2] == ["benchmark", "policies"]:
        del parts[3:4]
    for holder in ("tasks", "loads"):
        if holder in parts:
            place = parts.index(holder) + 2
            del parts[place : place + 1]
    return ".".join(parts) or "the file"


def _did_you_mean(key: str) -> str:
    known = {field for model in _all_settings(Settings) for field in model.model_fields}
    close = difflib.get_close_matches(key, sorted(known), n=1)
    return f"; did you mean {close[0]!r}?" if close else "."


def _all_settings(kind: type[Settings]) -> Iterator[type[Settings]]:
    for below in kind.__subclasses__():
        yield below
        yield from _all_settings(below)

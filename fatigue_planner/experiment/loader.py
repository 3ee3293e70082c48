"""From a file to an Experiment, or one clear message."""

import difflib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from fatigue_planner.errors import ExperimentError
from fatigue_planner.experiment.feasibility import meaning_faults
from fatigue_planner.experiment.grids import expand_grids
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.settings import Settings
from fatigue_planner.yaml_reader import read_yaml

Location = tuple[int | str, ...]


def load_experiment(path: Path) -> Experiment:
    """The experiment of a file, checked completely.

    Raises ExperimentError: file, key, value, what is allowed; all faults of form at once, or else all of meaning.
    """
    experiment = parse_experiment(read_content(path), str(path))
    faults = meaning_faults(experiment)
    if faults:
        raise ExperimentError("\n".join(f"{path}: {fault}" for fault in faults))
    return experiment


def read_content(path: Path) -> dict[str, Any]:
    """What an experiment file says, its grids of actions written out. Raises ExperimentError."""
    content = read_yaml(path, ExperimentError)
    if not isinstance(content, dict):
        raise ExperimentError(f"{path}: is not a mapping of settings; see experiments/paper.yaml for an example.")
    try:
        return expand_grids(content)
    except ExperimentError as error:
        raise ExperimentError(f"{path}: {error}") from error


def parse_experiment(content: Mapping[str, Any], source: str) -> Experiment:
    """The experiment of a file's content, checked in form; `source` is its name. Raises ExperimentError: all faults."""
    try:
        return Experiment.model_validate(content, strict=True)
    except ValidationError as error:
        raise ExperimentError(fault_text(error, source)) from error


def fault_text(error: ValidationError, source: str, place: Callable[[Location], str] | None = None) -> str:
    """All faults, one per line: source, key, value, what is allowed; `place`: how the path of a key is written."""
    faults = dict.fromkeys(_describe(fault, place or _place) for fault in _telling(error.errors()))
    return "\n".join(f"{source}: {fault}" for fault in faults)


# pydantic's words for what a YAML file should have.
_SHAPES = {
    "dict_type": "should be a mapping of keys and values",
    "model_type": "should be a mapping of keys and values",
    "model_attributes_type": "should be a mapping of keys and values",
    "tuple_type": "should be a list",
    "union_tag_not_found": "needs a kind",
}
LONGEST_VALUE = 60


def _telling(faults: list[ErrorDetails]) -> list[ErrorDetails]:
    """The faults without those that only follow from others: a key missing because it is misspelt, a list too
    short because what is in it is wrong.
    """
    misspelt = {
        (*fault["loc"][:-1], close)
        for fault in faults
        if fault["type"] == "extra_forbidden"
        for close in difflib.get_close_matches(str(fault["loc"][-1]), _known_keys(), n=1)
    }
    inside = {fault["loc"][:-1] for fault in faults}
    return [
        fault
        for fault in faults
        if not (fault["type"] == "missing" and fault["loc"] in misspelt)
        and not (fault["type"] == "too_short" and fault["loc"] in inside)
    ]


def _describe(fault: ErrorDetails, place_of: Callable[[Location], str]) -> str:
    place = place_of(fault["loc"])
    value = fault["input"]
    if fault["type"] == "extra_forbidden":
        return f"{place}: unknown key{_did_you_mean(str(fault['loc'][-1]))}"
    if fault["type"] == "missing":
        return f"{place}: is missing."
    if fault["type"] == "value_error":
        return f"{place}: {fault['ctx']['error']}." if fault["loc"] else f"{fault['ctx']['error']}."
    if fault["type"] == "union_tag_invalid":
        return f"{place}.kind = {fault['ctx']['tag']!r}: should be one of {fault['ctx']['expected_tags']}."
    shown = ""
    if isinstance(value, (str, int, float, bool, type(None))):
        text = repr(value)
        shown = f" = {text if len(text) <= LONGEST_VALUE else text[:LONGEST_VALUE] + '…'}"
    message = _SHAPES.get(fault["type"], fault["msg"][0].lower() + fault["msg"][1:])
    return f"{place}{shown}: {message}."


def _place(location: Location) -> str:
    """The path of a key; behind an entry with a `kind` pydantic adds the kind, which the file has not."""
    parts = [str(part) for part in location]
    if parts[:2] == ["benchmark", "policies"] or parts[:1] == ["hidden_workers"]:
        del parts[3:4]  # benchmark.policies.<name>.<kind>..., hidden_workers.<name>.<parameter>.<kind>...
    if parts[:1] == ["belief"]:
        del parts[1:2]
    # preferences.<name>.tasks.<number>.<kind>..., actions.<name>.loads.<number>.<kind>...
    if (parts[0:1], parts[2:3]) in ((["preferences"], ["tasks"]), (["actions"], ["loads"])):
        del parts[4:5]
    return ".".join(parts) or "the file"


def _did_you_mean(key: str) -> str:
    known = _known_keys()
    if key in known:
        return f" here; {key!r} belongs elsewhere, see experiments/paper.yaml."
    close = difflib.get_close_matches(key, known, n=1)
    return f"; did you mean {close[0]!r}?" if close else "."


def _known_keys() -> list[str]:
    names = {field.alias or name for model in _all_settings(Settings) for name, field in model.model_fields.items()}
    return sorted(names)


def _all_settings(kind: type[Settings]) -> Iterator[type[Settings]]:
    for below in kind.__subclasses__():
        yield below
        yield from _all_settings(below)

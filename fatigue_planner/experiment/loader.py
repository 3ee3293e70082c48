"""From a file to an Experiment, or one clear message; and what a file may say, for editors."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from fatigue_planner.core.errors import ExperimentError, FatplanError
from fatigue_planner.core.file_kinds import FileKind, mapping_of_kind
from fatigue_planner.core.files import find_shipped
from fatigue_planner.core.settings import Settings
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.error_messages import error_message, joined_errors
from fatigue_planner.experiment.pose_grid import AXES, Range, expand_pose_grids
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.experiment.semantic_checks import semantic_errors
from fatigue_planner.motion.action import Position

S = TypeVar("S", bound=Settings)

# Kinds of points whose coordinates may be ranges: an action's, and a station's.
GRIDS = {Position.__name__, "Place"}
DIALECT = "https://json-schema.org/draft/2020-12/schema"
# Below these keys are entries that users name themselves; what is left out in one is not worth a word.
ENTRIES = (
    "actions", "preferences", "initial_beliefs", "hidden_workers", "choice_models", "recognition_by_action",
    "benchmark.conditions", "benchmark.policies", "statistics.families",
)  # fmt: skip


def load_experiment(path: Path) -> Experiment:
    """The experiment of a file, or one that ships with fatplan by its name, checked completely.

    Raises ExperimentError: file, key, value, what is allowed; all errors of form at once, or else all of meaning.
    """
    path = find_shipped(path)
    experiment = parse_experiment(read_content(path), str(path))
    errors = semantic_errors(experiment)
    if errors:
        raise ExperimentError(joined_errors(str(path), errors))
    return experiment


def read_mapping(path: Path, kind: FileKind, error_type: type[FatplanError]) -> dict[str, Any]:
    """What a file of settings says. Raises `error_type` if that is no mapping, or a file of another kind."""
    return mapping_of_kind(path, read_yaml(path, error_type), kind, error_type)


def parse_settings(kind: type[S], content: Mapping[str, Any], source: str, error_type: type[FatplanError]) -> S:
    """The settings that a file's content is, checked in form; `source` is its name. Raises `error_type`: all errors."""
    try:
        return kind.model_validate(content, strict=True)
    except ValidationError as error:
        raise error_type(error_message(error, kind, source)) from error


def read_content(path: Path) -> dict[str, Any]:
    """What an experiment file says, its grids of actions written out. Raises ExperimentError."""
    content = read_mapping(path, FileKind.EXPERIMENT, ExperimentError)
    expanded, errors = expand_pose_grids(content)
    if errors:
        raise ExperimentError(joined_errors(str(path), errors))
    return expanded


def parse_experiment(content: Mapping[str, Any], source: str) -> Experiment:
    """The experiment of a file's content, checked in form; `source` is its name. Raises ExperimentError: all errors."""
    return parse_settings(Experiment, content, source, ExperimentError)


def complete_content(experiment: Experiment) -> dict[str, Any]:
    """What a file says that leaves nothing to defaults."""
    content = experiment.model_dump(by_alias=True, exclude_none=True)
    for worker in content["workers"].values():
        if worker["human"] == content["human"]:
            del worker["human"]
    return content


def defaults_in(content: Mapping[str, Any], complete: Mapping[str, Any], above: str = "") -> Iterator[str]:
    """The dotted keys, or whole sections, that a file's content leaves to defaults other than nothing."""
    for name, value in complete.items():
        key = above + name
        if name not in content:
            if value not in ({}, ()):
                yield key
        elif isinstance(value, dict) and key not in ENTRIES:
            yield from defaults_in(content[name], value, f"{key}.")


def editor_schema(kind: type[Settings]) -> dict[str, Any]:
    """The JSON Schema of a file; coordinates of places may be ranges (see `pose_grid`)."""
    schema = kind.model_json_schema()
    definitions = schema.get("$defs", {})
    for name in definitions.keys() & GRIDS:
        definitions[Range.__name__] = Range.model_json_schema()
        coordinates = definitions[name]["properties"]
        for axis, number in ((axis, coordinates[axis]) for axis in AXES):
            reference = {"$ref": f"#/$defs/{Range.__name__}"}
            coordinates[axis] = {"anyOf": [number, reference], "description": number["description"]}
    return {"$schema": DIALECT, **schema}

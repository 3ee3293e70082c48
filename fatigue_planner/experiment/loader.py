"""From a file to an Experiment, or one clear message."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.error_messages import error_message, joined_errors
from fatigue_planner.experiment.pose_grid import expand_pose_grids
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.experiment.semantic_checks import semantic_errors


def load_experiment(path: Path) -> Experiment:
    """The experiment of a file, checked completely.

    Raises ExperimentError: file, key, value, what is allowed; all faults of form at once, or else all of meaning.
    """
    experiment = parse_experiment(read_content(path), str(path))
    faults = semantic_errors(experiment)
    if faults:
        raise ExperimentError(joined_errors(str(path), faults))
    return experiment


def read_content(path: Path) -> dict[str, Any]:
    """What an experiment file says, its grids of actions written out. Raises ExperimentError."""
    content = read_yaml(path, ExperimentError)
    if not isinstance(content, dict):
        raise ExperimentError(f"{path}: is not a mapping of settings; see experiments/paper.yaml for an example.")
    expanded, faults = expand_pose_grids(content)
    if faults:
        raise ExperimentError(joined_errors(str(path), faults))
    return expanded


def parse_experiment(content: Mapping[str, Any], source: str) -> Experiment:
    """The experiment of a file's content, checked in form; `source` is its name. Raises ExperimentError: all faults."""
    try:
        return Experiment.model_validate(content, strict=True)
    except ValidationError as error:
        raise ExperimentError(error_message(error, Experiment, source)) from error

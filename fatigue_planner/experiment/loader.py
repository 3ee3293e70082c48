"""From a file to an Experiment, or one clear message."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fatigue_planner.core.errors import ExperimentError, listed
from fatigue_planner.core.files import PACKAGE
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.experiment.error_messages import error_message, joined_errors
from fatigue_planner.experiment.pose_grid import expand_pose_grids
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.experiment.semantic_checks import semantic_errors


def shipped_folder() -> Path:
    """The folder of the experiments that ship with fatplan: the repository's, which the build puts into the wheel."""
    inside = PACKAGE / "shipped"
    return inside if inside.is_dir() else PACKAGE.parent / "experiments"


def find_experiment(path: Path) -> Path:
    """The file that is meant: itself or, where there is no such file, the one of this name that ships with fatplan.

    Raises ExperimentError, naming those that ship, if a name (no folder, no `.yaml`) is none of them.
    """
    if path.exists() or path.name != str(path) or path.suffix in {".yaml", ".yml"}:
        return path
    shipped = shipped_folder() / f"{path}.yaml"
    if shipped.exists():
        return shipped
    names = [file.stem for file in sorted(shipped_folder().glob("*.yaml"))]
    raise ExperimentError(f"{path}: neither a file nor the name of one that ships with fatplan: {listed(names)}.")


def load_experiment(path: Path) -> Experiment:
    """The experiment of a file, or one that ships with fatplan by its name, checked completely.

    Raises ExperimentError: file, key, value, what is allowed; all faults of form at once, or else all of meaning.
    """
    path = find_experiment(path)
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

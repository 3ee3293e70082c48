"""From a file to an Experiment, or one clear message."""

import difflib
from pathlib import Path

import numpy as np
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from fatigue_planner.errors import DataFileError, ExperimentError
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.parameters import fatigue_state
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.joint_data import maximum_torques
from fatigue_planner.human.model import build_human
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
        experiment = Experiment.model_validate(content, strict=True)
    except ValidationError as error:
        faults = [_describe(fault) for fault in error.errors()]
        raise ExperimentError("\n".join(f"{path}: {fault}" for fault in faults)) from error
    try:
        _check_meaning(experiment)
    except DataFileError as error:
        raise ExperimentError(f"{path}: {error}") from error
    return experiment


def _check_meaning(experiment: Experiment) -> None:
    """What the types cannot say: names of joints and strength sets, targets no arm can reach."""
    build_human(experiment.worker)
    maximum_torques(experiment.worker.strength)
    for states in experiment.initial_beliefs.values():
        for state in states:
            fatigue_state(state.fatigue)
    longest = _longest_reach_m(experiment)
    for name, action in experiment.actions.items():
        position = action.position_m
        distance = float(np.linalg.norm([position.x, position.y, position.z]))
        if distance > longest:
            raise DataFileError(
                f"actions.{name}.position_m: {distance:.2f} m from the feet; this worker's ankle, leg, trunk and "
                f"arm together measure {longest:.2f} m."
            )


def _longest_reach_m(experiment: Experiment) -> float:
    """No posture reaches farther from the centre of the feet: the stretched chain from sole to fist."""
    body = Anthropometry(experiment.worker.height_m, experiment.worker.mass_kg, experiment.worker.sex)
    arm = ["right_shoulder", "right_elbow", "right_wrist"]
    links = [
        body.joint_centre(joint) for joint in ["right_knee", "right_ankle", "right_hip", "lumbar", "thoracic", *arm]
    ]
    heel, toe, _, height = body.sole_rectangle()
    feet = np.array([(heel + toe) / 2, body.length("hip_half_width"), height])
    return float(sum(np.linalg.norm(link) for link in [feet, *links, body.grip_m()]))


def _describe(fault: ErrorDetails) -> str:
    place = _place(fault["loc"])
    value = fault["input"]
    match fault["type"]:
        case "extra_forbidden":
            return f"{place}: unknown key{_did_you_mean(str(fault['loc'][-1]))}"
        case "missing":
            return f"{place}: is missing."
        case "value_error":
            return f"{fault['ctx']['error']}."
        case _:
            shown = f" = {value!r}" if isinstance(value, (str, int, float, bool, type(None))) else ""
            return f"{place}{shown}: {fault['msg'][0].lower()}{fault['msg'][1:]}."


def _place(location: tuple[int | str, ...]) -> str:
    """The path of a key; behind a policy's name pydantic adds the policy's kind, which the file has not."""
    parts = [str(part) for part in location]
    if parts[:2] == ["benchmark", "policies"]:
        del parts[3:4]
    return ".".join(parts) or "the file"


def _did_you_mean(key: str) -> str:
    known = {field for model in Settings.__subclasses__() for field in model.model_fields}
    close = difflib.get_close_matches(key, sorted(known), n=1)
    return f"; did you mean {close[0]!r}?" if close else "."

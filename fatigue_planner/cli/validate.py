"""`fatplan validate` and `fatplan schema`: what a file of settings says, and what it may say."""

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from fatigue_planner.cli.options import Json, present
from fatigue_planner.core.errors import ExperimentError, FatplanError


class Kind(StrEnum):
    """The kinds of files that users write."""

    EXPERIMENT = "experiment"
    CLAIMS = "claims"
    STUDY = "study"


def kind_of(content: Any) -> Kind:
    """The kind of a file's content, by the key that only it has."""
    if isinstance(content, dict) and "factors" in content:
        return Kind.STUDY
    return Kind.CLAIMS if isinstance(content, dict) and "claims" in content else Kind.EXPERIMENT


def validate(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An experiment, a file of claims, or a study (YAML).")],
    as_json: Json = False,
) -> None:
    """Check a FILE of settings completely, without running anything, and list all its faults at once."""
    from fatigue_planner.core.yaml_reader import read_yaml

    kind, about, error, faults = None, "", None, []
    try:
        kind = kind_of(read_yaml(file, ExperimentError))
        about = _about(file, kind)
    except FatplanError as fault:
        if not as_json:
            raise
        error = fault
        faults = [{"message": line.removeprefix(f"{file}: ")} for line in str(error).splitlines()]
    document = {"file": file, "kind": kind, "valid": error is None, "faults": faults, "about": about}
    present(document, f"{file}: ok; {about}.", as_json)
    if error is not None:
        typer.echo(f"Error: {error}", err=True)
        raise typer.Exit(error.exit_code)


def schema(
    kind: Annotated[Kind, typer.Argument(help="The kind of file.")] = Kind.EXPERIMENT,
) -> None:
    """Print the JSON Schema of a kind of file, for editors that complete and check YAML as you type."""
    from fatigue_planner.experiment.editor_schema import editor_schema
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.study.claims.schema import ClaimsFile
    from fatigue_planner.study.sensitivity.settings import StudySettings

    settings: dict[Kind, Any] = {Kind.EXPERIMENT: Experiment, Kind.CLAIMS: ClaimsFile, Kind.STUDY: StudySettings}
    typer.echo(json.dumps(editor_schema(settings[kind]), indent=1))


def _about(file: Path, kind: Kind) -> str:
    """What a file is about. What reads it is loaded when its kind is known; raises what that raises."""
    from fatigue_planner.output.reports.html.blocks import counted

    if kind is Kind.CLAIMS:
        from fatigue_planner.study.claims.loader import load_claims

        loaded = load_claims(file)
        return f"{len(loaded.claims)} claims about {loaded.experiment_file}"
    if kind is Kind.STUDY:
        from fatigue_planner.study.sensitivity.study import load_study

        study = load_study(file)
        return f"a study of {len(study.settings.factors)} settings of {study.base_file}"
    from fatigue_planner.experiment.loader import load_experiment

    experiment = load_experiment(file)
    grid = experiment.benchmark
    reactions = len(experiment.workers) * len(experiment.actions) * len(experiment.preferences)
    cells = len(grid.conditions) * len(grid.n_cycles) * len(grid.policies)
    return (
        f"{counted(reactions, 'reaction')} ({counted(len(experiment.workers), 'worker')} x "
        f"{counted(len(experiment.actions), 'action')} x {counted(len(experiment.preferences), 'preference')}), "
        f"{counted(cells, 'cell')} of up to {counted(grid.trials, 'trial')}"
    )

"""`fatplan validate` and `fatplan schema`: what a file of settings says, and what it may say."""

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from fatigue_planner.errors import ExperimentError
from fatigue_planner.experiment.editor_schema import editor_schema
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reports.html.words import counted
from fatigue_planner.yaml_reader import read_yaml


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
) -> None:
    """Check a FILE of settings completely, without doing anything: all faults are told at once."""
    kind = kind_of(read_yaml(file, ExperimentError))
    if kind is Kind.CLAIMS:
        from fatigue_planner.claims.loader import load_claims  # noqa: PLC0415

        loaded = load_claims(file)
        typer.echo(f"{file}: ok; {len(loaded.claims)} claims about {loaded.experiment_file}.")
    elif kind is Kind.STUDY:
        from fatigue_planner.sensitivity.study import load_study  # noqa: PLC0415

        study = load_study(file)
        typer.echo(f"{file}: ok; a study of {len(study.settings.factors)} settings of {study.base_file}.")
    else:
        typer.echo(f"{file}: ok; {_size(load_experiment(file))}.")


def schema(
    kind: Annotated[Kind, typer.Argument(help="Of which kind of file.")] = Kind.EXPERIMENT,
) -> None:
    """Print the JSON Schema of a kind of file, for editors that complete and check YAML while one types."""
    typer.echo(json.dumps(editor_schema(_settings_of(kind)), indent=1))


def _settings_of(kind: Kind) -> Any:
    if kind is Kind.CLAIMS:
        from fatigue_planner.claims.schema import ClaimsFile  # noqa: PLC0415

        return ClaimsFile
    if kind is Kind.STUDY:
        from fatigue_planner.sensitivity.settings import StudySettings  # noqa: PLC0415

        return StudySettings
    return Experiment


def _size(experiment: Experiment) -> str:
    grid = experiment.benchmark
    reactions = len(experiment.workers) * len(experiment.actions) * len(experiment.preferences)
    cells = len(grid.conditions) * len(grid.n_cycles) * len(grid.policies)
    return (
        f"{counted(reactions, 'reaction')} ({counted(len(experiment.workers), 'worker')} x "
        f"{counted(len(experiment.actions), 'action')} x {counted(len(experiment.preferences), 'preference')}), "
        f"{counted(cells, 'cell')} of up to {counted(grid.trials, 'trial')}"
    )

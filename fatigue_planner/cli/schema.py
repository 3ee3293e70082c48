"""`fatplan schema`: what a file of settings may say."""

import json
from typing import Annotated, Any

import typer

from fatigue_planner.cli.validate import Kind
from fatigue_planner.experiment.loader import editor_schema
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.study.claims.schema import ClaimsFile
from fatigue_planner.study.sensitivity.settings import StudySettings

SETTINGS_OF: dict[Kind, Any] = {Kind.EXPERIMENT: Experiment, Kind.CLAIMS: ClaimsFile, Kind.STUDY: StudySettings}


def schema(
    kind: Annotated[Kind, typer.Argument(help="Of which kind of file.")] = Kind.EXPERIMENT,
) -> None:
    """Print the JSON Schema of a kind of file, for editors that complete and check YAML while one types."""
    typer.echo(json.dumps(editor_schema(SETTINGS_OF[kind]), indent=1))

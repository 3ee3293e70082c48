"""`fatplan validate`: whether a file of settings says what it may."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli.json_output import Fault, Validation
from fatigue_planner.cli.output import Json, present
from fatigue_planner.core.errors import ExperimentError, FatplanError
from fatigue_planner.core.text import counted
from fatigue_planner.core.yaml_reader import read_yaml

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment


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
    """Check a FILE of settings completely, without doing anything: all faults are told at once."""
    kind = None
    try:
        kind = kind_of(read_yaml(file, ExperimentError))
        about = _about(file, kind)
    except FatplanError as error:
        if not as_json:
            raise
        faults = [Fault(line.removeprefix(f"{file}: ")) for line in str(error).splitlines()]
        present(Validation(file, kind, False, faults, ""), "", as_json)
        typer.echo(f"Error: {error}", err=True)
        raise typer.Exit(error.exit_code) from error
    present(Validation(file, kind, True, (), about), f"{file}: ok; {about}.", as_json)


def _about(file: Path, kind: Kind) -> str:
    """What a file is about. What reads it is loaded when its kind is known; raises what that raises."""
    if kind is Kind.CLAIMS:
        from fatigue_planner.study.claims.loader import load_claims  # noqa: PLC0415

        loaded = load_claims(file)
        return f"{len(loaded.claims)} claims about {loaded.experiment_file}"
    if kind is Kind.STUDY:
        from fatigue_planner.study.sensitivity.study import load_study  # noqa: PLC0415

        study = load_study(file)
        return f"a study of {len(study.settings.factors)} settings of {study.base_file}"
    from fatigue_planner.experiment.loader import load_experiment  # noqa: PLC0415

    return _size(load_experiment(file))


def _size(experiment: "Experiment") -> str:
    grid = experiment.benchmark
    reactions = len(experiment.workers) * len(experiment.actions) * len(experiment.preferences)
    cells = len(grid.conditions) * len(grid.n_cycles) * len(grid.policies)
    return (
        f"{counted(reactions, 'reaction')} ({counted(len(experiment.workers), 'worker')} x "
        f"{counted(len(experiment.actions), 'action')} x {counted(len(experiment.preferences), 'preference')}), "
        f"{counted(cells, 'cell')} of up to {counted(grid.trials, 'trial')}"
    )

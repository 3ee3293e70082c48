"""`fatplan validate`: whether a file of settings says what it may."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
import yaml

from fatigue_planner.cli.json_output import Fault, Validation
from fatigue_planner.cli.output import Json, present
from fatigue_planner.core.errors import ExperimentError, FatplanError
from fatigue_planner.core.yaml_reader import read_yaml
from fatigue_planner.output.reports.html.blocks import counted

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
    resolved: Annotated[
        bool, typer.Option("--resolved", help="Print the experiment with all defaults written out (YAML).")
    ] = False,
    as_json: Json = False,
) -> None:
    """Check a FILE of settings completely, without doing anything: all faults are told at once."""
    kind = None
    try:
        kind = kind_of(read_yaml(file, ExperimentError))
        if resolved and kind is not Kind.EXPERIMENT:
            raise ExperimentError(f"{file}: --resolved is for experiments only.")
        document, text = _checked(file, kind, resolved)
    except FatplanError as error:
        if not as_json:
            raise
        faults = [Fault(line.removeprefix(f"{file}: ")) for line in str(error).splitlines()]
        present(Validation(file, kind, False, faults, "", (), None), "", as_json)
        typer.echo(f"Error: {error}", err=True)
        raise typer.Exit(error.exit_code) from error
    present(document, text, as_json)


def _checked(file: Path, kind: Kind, resolved: bool) -> tuple[Validation, str]:
    """A valid file, as a document and in words. What reads it is loaded when its kind is known; raises what it does."""
    if kind is Kind.CLAIMS:
        from fatigue_planner.study.claims.loader import load_claims  # noqa: PLC0415

        loaded = load_claims(file)
        about = f"{len(loaded.claims)} claims about {loaded.experiment_file}"
        return Validation(file, kind, True, (), about, (), None), f"{file}: ok; {about}."
    if kind is Kind.STUDY:
        from fatigue_planner.study.sensitivity.study import load_study  # noqa: PLC0415

        study = load_study(file)
        about = f"a study of {len(study.settings.factors)} settings of {study.base_file}"
        return Validation(file, kind, True, (), about, (), None), f"{file}: ok; {about}."
    from fatigue_planner.experiment import loader  # noqa: PLC0415

    experiment = loader.load_experiment(file)
    complete = loader.complete_content(experiment)
    defaults = list(loader.defaults_in(loader.read_content(file), complete))
    about = _size(experiment)
    text = f"{file}: ok; {about}."
    if defaults:
        text += f"\nLeft to defaults: {', '.join(defaults)} (--resolved prints them)."
    if resolved:
        text = yaml.safe_dump(complete, sort_keys=False, default_flow_style=None, width=120).rstrip()
    return Validation(file, kind, True, (), about, defaults, complete if resolved else None), text


def _size(experiment: "Experiment") -> str:
    grid = experiment.benchmark
    reactions = len(experiment.workers) * len(experiment.actions) * len(experiment.preferences)
    cells = len(grid.conditions) * len(grid.n_cycles) * len(grid.policies)
    return (
        f"{counted(reactions, 'reaction')} ({counted(len(experiment.workers), 'worker')} x "
        f"{counted(len(experiment.actions), 'action')} x {counted(len(experiment.preferences), 'preference')}), "
        f"{counted(cells, 'cell')} of up to {counted(grid.trials, 'trial')}"
    )

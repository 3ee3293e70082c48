"""`fatplan validate` and `fatplan schema`: what a file of settings says, and what it may say."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.core.errors import ExperimentError, FatplanError
from fatigue_planner.core.file_kinds import FileKind, kind_of
from fatigue_planner.core.text import counted

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment


def validate(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="An experiment, a station, a line, a file of claims, or a study (YAML)."),
    ],
    resolved: Annotated[
        bool, typer.Option("--resolved", help="Print the experiment with all defaults written out (YAML).")
    ] = False,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Check a FILE of settings completely, without running anything, and list all its faults at once."""
    from fatigue_planner.core.files import find_shipped
    from fatigue_planner.core.yaml_reader import read_yaml

    document: dict[str, Any] = {"file": file, "kind": None, "valid": False, "faults": [], "about": ""}
    document |= {"defaults": (), "resolved": None}
    error, text = None, ""
    try:
        file = find_shipped(file)
        kind = kind_of(read_yaml(file, ExperimentError))
        document |= {"file": file, "kind": kind}
        if resolved and kind is not FileKind.EXPERIMENT:
            raise ExperimentError(f"{file}: --resolved is for experiments only.")
        told, text = summary(file, kind, resolved)
        document |= {"valid": True, **told}
    except FatplanError as fault:
        if not as_json:
            raise
        error = fault
        document["faults"] = [{"message": line.removeprefix(f"{file}: ")} for line in str(error).splitlines()]
    options.present(document, text, as_json)
    if error is not None:
        typer.echo(f"Error: {error}", err=True)
        raise typer.Exit(error.exit_code)


def schema(
    kind: Annotated[FileKind, typer.Argument(help="The kind of file.")] = FileKind.EXPERIMENT,
    plugins: options.Plugins = None,
) -> None:
    """Print the JSON Schema of a kind of file, for editors that complete and check YAML as you type."""
    from fatigue_planner.experiment.loader import editor_schema
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.station.line.schema import Line
    from fatigue_planner.station.schema import Station
    from fatigue_planner.study.claims.schema import ClaimsFile
    from fatigue_planner.study.sensitivity.settings import StudySettings

    settings: dict[FileKind, Any] = {
        FileKind.EXPERIMENT: Experiment,
        FileKind.CLAIMS: ClaimsFile,
        FileKind.STUDY: StudySettings,
        FileKind.STATION: Station,
        FileKind.LINE: Line,
    }
    typer.echo(json.dumps(editor_schema(settings[kind]), indent=1))


def summary(file: Path, kind: FileKind, resolved: bool = False) -> tuple[dict[str, Any], str]:
    """What a valid file is about, for the document and in words.

    What reads it is loaded when its kind is known; raises what that raises.
    """
    if kind is FileKind.CLAIMS:
        from fatigue_planner.study.claims.loader import load_claims

        loaded = load_claims(file)
        about = f"{len(loaded.claims)} claims about {loaded.experiment_file}"
        return {"about": about}, f"{file}: ok; {about}."
    if kind is FileKind.STUDY:
        from fatigue_planner.study.sensitivity.study import load_study

        study = load_study(file)
        about = f"a study of {len(study.settings.factors)} settings of {study.base_file}"
        return {"about": about}, f"{file}: ok; {about}."
    if kind is FileKind.LINE:
        from fatigue_planner.station.line.loader import load_line

        line = load_line(file).line
        about = f"a line with {counted(len(line.stations), 'station')}, a crew of {len(line.crew)}"
        return {"about": about}, f"{file}: ok; {about}."
    if kind is FileKind.STATION:
        from fatigue_planner.station.loader import load_station

        station = load_station(file)
        about = (
            f"a station with {counted(len(station.operations), 'operation')}, {counted(len(station.workers), 'worker')}"
        )
        return {"about": about}, f"{file}: ok; {about}."
    from fatigue_planner.experiment import loader

    experiment = loader.load_experiment(file)
    complete = loader.complete_content(experiment)
    defaults = list(loader.defaults_in(loader.read_content(file), complete))
    about = _size(experiment)
    text = f"{file}: ok; {about}."
    if defaults:
        text += f"\nLeft to defaults: {', '.join(defaults)} (--resolved prints them)."
    if resolved:
        import yaml

        text = yaml.safe_dump(complete, sort_keys=False, default_flow_style=None, width=120).rstrip()
    return {"about": about, "defaults": defaults, "resolved": complete if resolved else None}, text


def _size(experiment: "Experiment") -> str:
    grid = experiment.benchmark
    reactions = len(experiment.workers) * len(experiment.actions) * len(experiment.preferences)
    cells = len(grid.conditions) * len(grid.n_cycles) * len(grid.policies)
    return (
        f"{counted(reactions, 'reaction')} ({counted(len(experiment.workers), 'worker')} x "
        f"{counted(len(experiment.actions), 'action')} x {counted(len(experiment.preferences), 'preference')}), "
        f"{counted(cells, 'cell')} of up to {counted(grid.trials, 'trial')}"
    )

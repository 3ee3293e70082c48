"""`fatplan figures`: the figures of a finished benchmark."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import typer

from fatigue_planner.benchmark.table import TRIALS_FILE, read_table
from fatigue_planner.cli.options import (
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    DEFAULT_RESULTS,
    CacheFolder,
    ExperimentFile,
    ResultsFolder,
    command_line,
)
from fatigue_planner.errors import StaleTableError
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import load_reactions
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.parameters import fatigue_parameters
from fatigue_planner.figures.reactions import posture_figure, torque_figure
from fatigue_planner.figures.returns import returns_figure
from fatigue_planner.figures.style import save_figure
from fatigue_planner.files import writable_folder
from fatigue_planner.human.model import build_human
from fatigue_planner.provenance import check_manifest, publish_manifest
from fatigue_planner.reactions.reaction import Reaction, digests
from fatigue_planner.statistics.comparison import comparison_table

# Settings that a table of trials does not depend on.
NOT_IN_THE_TABLE = ("figures", "significance_level")


def figures(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT,
    cache: CacheFolder = DEFAULT_CACHE,
    results: ResultsFolder = DEFAULT_RESULTS,
) -> None:
    """Draw the figures of an EXPERIMENT: returns per policy, postural reactions and their torques.

    Needs the results of `fatplan benchmark`. Every figure is a PNG and an SVG, with its data as CSV.
    """
    settings = load_experiment(experiment)
    reactions = load_reactions(settings, cache, command_line("simulate", experiment, cache))
    folder = results / settings.name
    command = command_line("benchmark", experiment, cache, results)
    trials = read_table(folder, command)
    _check_origin(check_manifest(folder, "benchmark", TRIALS_FILE, command), settings, reactions, folder, command)
    writable_folder(folder)
    comparison = comparison_table(trials, settings.significance_level)
    files = []
    for name, conditions in settings.figures.items():
        figure = returns_figure(comparison, conditions, list(settings.benchmark.policies))
        files += save_figure(folder, name, figure, comparison[comparison["condition"].isin(conditions)])
    human = build_human(settings.worker, settings.tool.mass_kg)
    parameters = fatigue_parameters(settings.fatigue, settings.worker.strength)
    files += save_figure(folder, "reactions", *posture_figure(human, reactions, parameters))
    files += save_figure(folder, "torques", *torque_figure(reactions, parameters))
    configuration = {"reactions": digests(reactions)}
    publish_manifest(folder, "figures", configuration, files)
    for path in files:
        if path.suffix == ".png":
            typer.echo(f"{path} (and .svg, .csv)")


def _check_origin(
    note: Mapping[str, Any], settings: Experiment, reactions: Sequence[Reaction], folder: Path, command: str
) -> None:
    """Raise StaleTableError, naming what differs, unless the table was made from these settings and reactions."""
    made, now = note["experiment"], settings.plain()
    changed = [key for key in now if key not in NOT_IN_THE_TABLE and made.get(key) != now[key]]
    if note["reactions"] != digests(reactions):
        changed.append("reactions")
    if changed:
        raise StaleTableError(
            f"{folder / TRIALS_FILE}: was made with other settings ({', '.join(changed)}). Run `{command}`."
        )

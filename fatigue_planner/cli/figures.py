"""`fatplan figures`: the figures of a finished benchmark."""

import typer

from fatigue_planner.cli.options import (
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    DEFAULT_RESULTS,
    CacheFolder,
    ExperimentFile,
    ResultsFolder,
    command_line,
)
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import load_reactions, reaction_requests
from fatigue_planner.files import writable_folder
from fatigue_planner.provenance import publish_manifest
from fatigue_planner.reactions.reaction import digests


def figures(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT,
    cache: CacheFolder = DEFAULT_CACHE,
    results: ResultsFolder = DEFAULT_RESULTS,
) -> None:
    """Draw the figures of an EXPERIMENT: returns per policy, postural reactions, their loads and costs.

    Needs the reactions of `fatplan simulate` and, if the experiment names figures of returns, the results
    of `fatplan benchmark`. Every figure is a PNG and an SVG, with its data as CSV.
    """
    from fatigue_planner.cli.drawing import draw_reactions, draw_returns  # noqa: PLC0415 - loads matplotlib

    settings = load_experiment(experiment)
    reactions = load_reactions(settings, cache, command_line("simulate", experiment, cache))
    folder = results / settings.name
    files = []
    if settings.figures:
        files += draw_returns(settings, folder, command_line("benchmark", experiment, cache, results))
    files += draw_reactions(settings, reactions, writable_folder(folder))
    publish_manifest(folder, "figures", {"reactions": digests(reaction_requests(settings))}, files)
    for path in files:
        if path.suffix == ".png":
            typer.echo(f"{path} (and .svg, .csv)")

"""`fatplan figures`: the figures of a finished benchmark."""

from fatigue_planner.cli.json_output import FilesOf
from fatigue_planner.cli.options import (
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    DEFAULT_RESULTS,
    CacheFolder,
    ExperimentFile,
    ResultsFolder,
    command_line,
)
from fatigue_planner.cli.output import Json, present
from fatigue_planner.cli.progress import warn
from fatigue_planner.core.files import writable_folder
from fatigue_planner.core.provenance import publish_manifest
from fatigue_planner.experiment.build import load_reactions, reaction_requests, worker_fatigue
from fatigue_planner.experiment.feasibility import omissions, without_infeasible
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.reactions.reaction import digests
from fatigue_planner.study.benchmark.results import load_results
from fatigue_planner.study.statistics.comparison import comparison_table


def figures(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT,
    cache: CacheFolder = DEFAULT_CACHE,
    results: ResultsFolder = DEFAULT_RESULTS,
    as_json: Json = False,
) -> None:
    """Draw the figures of an EXPERIMENT: returns per policy, postural reactions, their loads and costs.

    Needs the reactions of `fatplan simulate` and, if the experiment names figures of returns, the results
    of `fatplan benchmark`. Every figure is a PNG and an SVG, with its data as CSV.
    """
    settings = load_experiment(experiment)
    from fatigue_planner.output.reports.results.drawings import draw_reactions, draw_returns  # noqa: PLC0415 - matplotlib
    from fatigue_planner.output.reports.results.figure_folder import FigureFolder  # noqa: PLC0415

    reactions = load_reactions(settings, cache, command_line("simulate", experiment, cache))
    drawn = FigureFolder(results / settings.name)
    performed = {reaction.name for reaction in reactions}
    warn(omissions(settings, performed))
    feasible = without_infeasible(settings, performed)
    if feasible.figures:
        tables = load_results(settings, drawn.folder, command_line("benchmark", experiment, cache, results))
        draw_returns(drawn, feasible, comparison_table(tables.trials, settings.statistics.significance_level))
    writable_folder(drawn.folder)
    draw_reactions(drawn, settings, reactions, worker_fatigue(settings))
    note = {"reactions": digests(reaction_requests(settings))}
    hashes = publish_manifest(drawn.folder, "figures", note, drawn.files)
    pictures = [f"{path} (and .svg, .csv)" for path in drawn.files if path.suffix == ".png"]
    present(FilesOf(drawn.folder, hashes), "\n".join(pictures), as_json)

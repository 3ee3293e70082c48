"""`fatplan report`: one page with all results of an experiment."""

import time

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
from fatigue_planner.core.files import publish_text
from fatigue_planner.core.provenance import publish_manifest
from fatigue_planner.experiment.build import cycle_profiles, load_reactions, reaction_requests
from fatigue_planner.experiment.feasibility import omissions, without_infeasible
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.reactions.reaction import digests
from fatigue_planner.study.benchmark.results import courses, load_results
from fatigue_planner.study.benchmark.selection import cells


def report(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT,
    cache: CacheFolder = DEFAULT_CACHE,
    results: ResultsFolder = DEFAULT_RESULTS,
    as_json: Json = False,
) -> None:
    """Write the report of an EXPERIMENT: one page (HTML) that opens offline and prints, with its figures and tables.

    Needs the reactions of `fatplan simulate` and the tables of `fatplan benchmark`, which it checks row by row and
    does not change. Every run is lived through again from its actions; one that does not come to its return is named.
    """
    begin = time.perf_counter()
    settings = load_experiment(experiment)
    from fatigue_planner.output.reports.html.page import REPORT_FILE  # noqa: PLC0415 - loads jinja2
    from fatigue_planner.output.reports.results.figure_folder import FigureFolder  # noqa: PLC0415 - loads matplotlib
    from fatigue_planner.output.reports.results.report import report  # noqa: PLC0415
    from fatigue_planner.output.reports.results.report_data import ReportData  # noqa: PLC0415
    from fatigue_planner.output.reports.study.finished import study_of  # noqa: PLC0415

    simulate = command_line("simulate", experiment, cache)
    benchmark, own = (command_line(command, experiment, cache, results) for command in ("benchmark", "report"))
    reactions = load_reactions(settings, cache, simulate)
    folder = results / settings.name
    tables = load_results(settings, folder, benchmark)
    profiles = cycle_profiles(settings, reactions)
    left_out, feasible = omissions(settings, profiles), without_infeasible(settings, profiles)
    warn(left_out)
    grid = cells(feasible, profiles)
    report_data = ReportData(feasible, reactions, grid, tables, courses(grid, tables, folder), left_out)
    figures = FigureFolder(folder)
    path = folder / REPORT_FILE
    study = study_of(settings, results)
    commands = [simulate, f"{benchmark}{tables.options}", *(["fatplan sensitivity"] if study else []), own]
    publish_text(path, report(report_data, figures, experiment, commands, study))
    note = {"reactions": digests(reaction_requests(settings))}
    hashes = publish_manifest(folder, "report", note, [*figures.files, path])
    size = path.stat().st_size / 1e6
    text = (
        f"{path}: {size:.1f} MB; {len(figures.files)} files of figures and data beside it "
        f"({time.perf_counter() - begin:.1f} s)."
    )
    present(FilesOf(folder, hashes), text, as_json)

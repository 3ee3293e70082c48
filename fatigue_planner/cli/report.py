"""`fatplan report`: one page with all results of an experiment, or its figures only."""

import time
from pathlib import Path
from typing import Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import warn


def report(
    experiment: Annotated[
        Path, typer.Argument(metavar="EXPERIMENT", help="The experiment file (YAML), or a folder of its results.")
    ] = options.DEFAULT_EXPERIMENT,
    cycles: options.Cycles = None,
    conditions: options.Conditions = None,
    policies: options.Policies = None,
    trials: options.Trials = None,
    descents: options.Descents = None,
    seed: options.Seed = None,
    figures_only: Annotated[
        bool,
        typer.Option("--figures-only", help="Only draw the figures of returns and reactions, without the page."),
    ] = False,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Write one page (HTML) with all results of an EXPERIMENT, its figures and tables; it opens offline and prints.

    Needs the reactions of `fatplan simulate` and the tables of `fatplan benchmark`, which it checks row by row and
    never changes. Every run is replayed from its actions; a run whose return differs is named. Every figure is a PNG
    and an SVG, with its data as CSV. For a restricted grid, give the options that `fatplan benchmark` was given, or the
    folder of its results instead of the EXPERIMENT.
    """
    from fatigue_planner.core.files import find_shipped, publish_text, writable_folder
    from fatigue_planner.core.provenance import publish_manifest
    from fatigue_planner.experiment.build import cycle_profiles, load_reactions, reaction_requests, worker_fatigue
    from fatigue_planner.experiment.feasibility import omissions, without_infeasible
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.output.reports.page import REPORT_FILE
    from fatigue_planner.output.reports.results.report import report as report_page
    from fatigue_planner.output.reports.results.report_data import ReportData
    from fatigue_planner.output.reports.results.sections.reactions import draw_reactions
    from fatigue_planner.output.reports.results.sections.returns import draw_returns
    from fatigue_planner.output.reports.study.finished import studies_of
    from fatigue_planner.reactions.reaction import digests
    from fatigue_planner.study.benchmark.results import load_results
    from fatigue_planner.study.benchmark.selection import Selection, selected

    begin = time.perf_counter()
    file, wanted = experiment, Selection(cycles, conditions, policies, trials, descents, seed)
    if experiment.is_dir():
        results, own = experiment.parent, options.command_line("report", experiment, cache)
        file, wanted = options.source_of(experiment, wanted)
    else:
        own = options.command_line("report", experiment, cache, results, wanted)
    settings = selected(load_experiment(file), wanted)
    folder = experiment if experiment.is_dir() else results / (settings.name + wanted.suffix())
    simulate = options.command_line("simulate", file, cache)
    benchmark = options.command_line("benchmark", file, cache, results, wanted)
    reactions = load_reactions(settings, cache, simulate)
    profiles = cycle_profiles(settings, reactions)
    feasible, left_out = (
        without_infeasible(settings, profiles, profiles.ruled_out),
        omissions(settings, profiles, profiles.ruled_out),
    )
    warn(left_out)
    figures = FigureFolder(folder)
    if figures_only:
        if feasible.figures:
            draw_returns(figures, feasible, load_results(settings, folder, benchmark).comparison)
        writable_folder(folder)
        draw_reactions(figures, settings, reactions, worker_fatigue(settings), profiles)
        files = figures.files
        text = "\n".join(f"{path} (and .svg, .csv)" for path in files if path.suffix == ".png")
    else:
        tables, studies = load_results(settings, folder, benchmark), studies_of(settings, folder.parent)
        made_by = [f"fatplan sensitivity {study.note.study.name}" for study in studies]
        commands = [simulate, benchmark + tables.options, *made_by, own]
        data = ReportData(
            feasible, reactions, profiles, tables, folder, find_shipped(file), commands, studies, left_out
        )
        publish_text(path := folder / REPORT_FILE, report_page(data, figures))
        files = [*figures.files, path]
        text = (
            f"{path}: {path.stat().st_size / 1e6:.1f} MB; {len(figures.files)} files of figures and data beside it "
            f"({time.perf_counter() - begin:.1f} s)."
        )
    note = {"reactions": digests(reaction_requests(settings))}
    hashes = publish_manifest(folder, "figures" if figures_only else "report", note, files)
    options.present({"folder": folder, "files": hashes}, text, as_json)

"""`fatplan report`: one page with all results of an experiment, or its figures only."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import warn

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.reactions.reaction import Reaction


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
    from fatigue_planner.experiment.build import load_reactions, reaction_requests
    from fatigue_planner.experiment.loader import load_experiment
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
    from fatigue_planner.core.provenance import publish_manifest
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.reactions.reaction import digests

    simulate = options.command_line("simulate", file, cache)
    benchmark = options.command_line("benchmark", file, cache, results, wanted)
    reactions = load_reactions(settings, cache, simulate)
    figures = FigureFolder(folder)
    if figures_only:
        files = _draw(settings, reactions, figures, benchmark)
        text = "\n".join(f"{path} (and .svg, .csv)" for path in files if path.suffix == ".png")
    else:
        path = _write_page(file, settings, reactions, figures, (simulate, benchmark, own))
        files = [*figures.files, path]
        text = (
            f"{path}: {path.stat().st_size / 1e6:.1f} MB; {len(figures.files)} files of figures and data beside it "
            f"({time.perf_counter() - begin:.1f} s)."
        )
    note = {"reactions": digests(reaction_requests(settings))}
    hashes = publish_manifest(figures.folder, "figures" if figures_only else "report", note, files)
    options.present({"folder": figures.folder, "files": hashes}, text, as_json)


def _draw(
    settings: "Experiment", reactions: "Sequence[Reaction]", figures: "FigureFolder", benchmark: str
) -> list[Path]:
    """Figures of the returns, if the experiment names some, and of the reactions; the command makes the tables."""
    from fatigue_planner.core.files import writable_folder
    from fatigue_planner.experiment.build import cycle_profiles, worker_fatigue
    from fatigue_planner.experiment.feasibility import omissions, without_infeasible
    from fatigue_planner.output.reports.results.sections.reactions import draw_reactions
    from fatigue_planner.output.reports.results.sections.returns import draw_returns
    from fatigue_planner.study.benchmark.results import load_results

    profiles = cycle_profiles(settings, reactions)
    feasible = without_infeasible(settings, profiles)
    warn(omissions(settings, profiles))
    if feasible.figures:
        tables = load_results(settings, figures.folder, benchmark)
        draw_returns(figures, feasible, tables.comparison)
    writable_folder(figures.folder)
    draw_reactions(figures, settings, reactions, worker_fatigue(settings), profiles)
    return figures.files


def _write_page(
    file: Path,
    settings: "Experiment",
    reactions: "Sequence[Reaction]",
    figures: "FigureFolder",
    commands: tuple[str, str, str],
) -> Path:
    """The page, its figures beside it; `commands` make the reactions, the tables and the page."""
    from fatigue_planner.core.files import find_shipped, publish_text
    from fatigue_planner.experiment.build import cycle_profiles
    from fatigue_planner.experiment.feasibility import omissions, without_infeasible
    from fatigue_planner.output.reports.html.page import REPORT_FILE
    from fatigue_planner.output.reports.results.report import report as report_page
    from fatigue_planner.output.reports.results.report_data import ReportData
    from fatigue_planner.output.reports.study.finished import study_of
    from fatigue_planner.study.benchmark.results import load_results

    simulate, benchmark, own = commands
    folder = figures.folder
    tables = load_results(settings, folder, benchmark)
    study = study_of(settings, folder.parent)
    shown = [simulate, f"{benchmark}{tables.options}", *(["fatplan sensitivity"] if study else []), own]
    path = folder / REPORT_FILE
    profiles = cycle_profiles(settings, reactions)
    feasible, left_out = without_infeasible(settings, profiles), omissions(settings, profiles)
    warn(left_out)
    report_data = ReportData(feasible, reactions, profiles, tables, folder, find_shipped(file), shown, study, left_out)
    publish_text(path, report_page(report_data, figures))
    return path

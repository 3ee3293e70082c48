"""`fatplan benchmark`: the grid of conditions, numbers of cycles and policies."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from fatigue_planner.benchmark.bounds import BOUNDS_FILE, publish_bounds, run_bounds
from fatigue_planner.benchmark.grid import Cell
from fatigue_planner.benchmark.runner import run_grid
from fatigue_planner.benchmark.table import OUTCOMES, REGRET_FILE, TIMES_FILE, TRIALS_FILE, publish_table, trial_table
from fatigue_planner.cli.options import (
    ALL_CORES,
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    DEFAULT_RESULTS,
    CacheFolder,
    ExperimentFile,
    Jobs,
    ResultsFolder,
    command_line,
    counter,
    talk,
)
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import load_cycle_profiles, reaction_requests
from fatigue_planner.experiment.selection import Selection, cells, selected
from fatigue_planner.files import publish_text, writable_folder
from fatigue_planner.planners.reference import describe
from fatigue_planner.provenance import MANIFEST_FILE, publish_manifest
from fatigue_planner.reactions.reaction import digests
from fatigue_planner.statistics.comparison import comparison_table
from fatigue_planner.statistics.contrast_text import contrast_text
from fatigue_planner.statistics.contrasts import CONTRASTS_FILE, contrasts
from fatigue_planner.statistics.gaps import gap_table, gap_text
from fatigue_planner.statistics.regret import regret_table, regret_text
from fatigue_planner.statistics.summary import summary_text

MOST = 1_000_000  # trials or descents: the schema's limit of both
SUMMARY_FILE = "summary.txt"
COMPARISON_FILE = "comparison.csv"


def benchmark(
    experiment: ExperimentFile = DEFAULT_EXPERIMENT,
    cycles: Annotated[list[int] | None, typer.Option(help="Only this number of cycles (repeatable).")] = None,
    conditions: Annotated[list[str] | None, typer.Option(help="Only this condition (repeatable).")] = None,
    policies: Annotated[list[str] | None, typer.Option(help="Only this policy (repeatable).")] = None,
    trials: Annotated[int | None, typer.Option(min=1, max=MOST, help="Trials per cell instead of the file's.")] = None,
    descents: Annotated[int | None, typer.Option(min=1, max=MOST, help="Descents of every POMCP.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed instead of the experiment's.")] = None,
    regret: Annotated[
        bool, typer.Option("--regret", help="Also measure what each decision loses against an exact lookahead.")
    ] = False,
    bound: Annotated[
        bool,
        typer.Option("--bound", help="Also compute a cost that no policy can beat."),
    ] = False,
    jobs: Jobs = ALL_CORES,
    cache: CacheFolder = DEFAULT_CACHE,
    results: ResultsFolder = DEFAULT_RESULTS,
) -> None:
    """Run every policy of an EXPERIMENT in every condition and compare their returns.

    Needs the reactions of `fatplan simulate`. Options restrict or change the experiment's grid; a
    changed grid gets a results folder of its own, named after the changes. An interrupted run goes on
    where it stopped when it is started again, and ends in the same table.
    """
    settings = load_experiment(experiment)
    wanted = Selection(cycles, conditions, policies, trials, descents, seed, regret)
    grid = selected(settings, wanted)
    profiles = load_cycle_profiles(settings, cache, command_line("simulate", experiment, cache))
    store = writable_folder(results / settings.name / "parts")
    folder = writable_folder(results / (settings.name + wanted.suffix()))
    grid_cells = cells(grid, profiles, regret)
    table = _run(grid_cells, store, jobs)
    publish_table(folder, table)
    comparison = comparison_table(table, settings.statistics.significance_level)
    publish_text(folder / COMPARISON_FILE, comparison.to_csv(index=False, lineterminator="\n"))
    contrasted = contrasts(table, settings.statistics, grid.benchmark.seed)
    publish_text(folder / CONTRASTS_FILE, contrasted.to_csv(index=False, lineterminator="\n"))
    summary = summary_text(comparison, settings.statistics.significance_level)
    summary += "\n" + contrast_text(contrasted, settings.statistics)
    files = [TRIALS_FILE, COMPARISON_FILE, CONTRASTS_FILE, SUMMARY_FILE]
    if regret:
        summary += "\n" + _regret_summary(grid_cells, table)
        files.append(REGRET_FILE)
    if bound:
        gaps = gap_table(comparison, _run_bounds(grid_cells, results / settings.name / "bounds", jobs))
        publish_bounds(folder, gaps)
        hidden = dict.fromkeys(cell.condition for cell in grid_cells if cell.situation.prior is not None)
        summary += "\n" + gap_text(gaps, list(hidden))
        files.append(BOUNDS_FILE)
    else:
        (folder / BOUNDS_FILE).unlink(missing_ok=True)  # of an earlier run, perhaps with other settings
    publish_text(folder / SUMMARY_FILE, summary)
    configuration = {
        "experiment": grid.plain(),
        "seed": grid.benchmark.seed,
        "reactions": digests(reaction_requests(settings)),
    }
    publish_manifest(folder, "benchmark", configuration, [folder / name for name in files])
    typer.echo(summary)
    others = ", ".join([*files[1:], TIMES_FILE, MANIFEST_FILE])
    typer.echo(f"{folder}: {TRIALS_FILE} ({len(table)} runs), {others}")


def _regret_summary(cells: Sequence[Cell], table: pd.DataFrame) -> str:
    references = {cell.condition: describe(cell.reference) for cell in cells if cell.reference is not None}
    return regret_text(regret_table(table), references)


def _run_bounds(cells: Sequence[Cell], store: Path, jobs: int) -> pd.DataFrame:
    with counter(talk()) as bar:
        places = {(cell.condition, cell.n_cycles) for cell in cells if cell.situation.prior is None}
        task = bar.add_task("Bounding the least cost", total=len(places))
        return run_bounds(cells, writable_folder(store), jobs, lambda: bar.advance(task))


def _run(cells: list[Cell], store: Path, jobs: int) -> pd.DataFrame:
    console = talk()
    total = sum(len(cell.trial_numbers()) * cell.n_cycles for cell in cells)
    share = TextColumn("{task.percentage:.0f} %")
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        share,
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=console,
    ) as bar:
        task = bar.add_task(f"Running {len(cells)} cells", total=total)
        done, warnings = run_grid(cells, store, jobs, lambda cell, n: bar.advance(task, n * cell.n_cycles))
    for warning in warnings:
        console.print(f"Warning: {warning}", markup=False)
    table = trial_table(cells, done)
    assert not table[OUTCOMES].isna().any(axis=None)
    return table

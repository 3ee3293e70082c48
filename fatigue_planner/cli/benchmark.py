"""`fatplan benchmark`: the grid of conditions, numbers of cycles and policies."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, TypeVar

import pandas as pd
import typer

from fatigue_planner.cli.json_output import BenchmarkPlan, BenchmarkRun
from fatigue_planner.cli.options import (
    ALL_CORES,
    DEFAULT_CACHE,
    DEFAULT_EXPERIMENT,
    DEFAULT_RESULTS,
    CacheFolder,
    Dask,
    ExperimentFile,
    Jobs,
    ResultsFolder,
    command_line,
    executor_of,
)
from fatigue_planner.cli.output import Json, present
from fatigue_planner.cli.progress import progress, warn
from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.core.files import publish_csv, publish_text, remove, writable_folder
from fatigue_planner.core.provenance import MANIFEST_FILE, publish_manifest
from fatigue_planner.experiment.build import load_cycle_profiles, reaction_requests
from fatigue_planner.experiment.feasibility import omissions, without_infeasible
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.output.reports.html.blocks import counted
from fatigue_planner.planners.reference import describe
from fatigue_planner.planners.settings import ReferenceSettings
from fatigue_planner.reactions.reaction import digests
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE, publish_bounds, run_bounds
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.estimate import decisions_left, duration_text, estimated_seconds
from fatigue_planner.study.benchmark.job import Job
from fatigue_planner.study.benchmark.regret import RegretJob
from fatigue_planner.study.benchmark.runner import run_grid
from fatigue_planner.study.benchmark.selection import Selection, cells, references, selected
from fatigue_planner.study.benchmark.tables import (
    ACTIONS_FILE,
    KEY,
    OUTCOMES,
    REGRET_FILE,
    TIMES_FILE,
    TRIALS_FILE,
    publish_table,
    regret_rows,
    trial_table,
)
from fatigue_planner.study.benchmark.trial import TrialResult
from fatigue_planner.study.statistics.comparison import comparison_table, summary_text
from fatigue_planner.study.statistics.contrast_text import contrast_text
from fatigue_planner.study.statistics.contrasts import CONTRASTS_FILE, contrasts
from fatigue_planner.study.statistics.pairing import records
from fatigue_planner.study.statistics.regret import gap_table, gap_text, regret_table, regret_text

MOST = 1_000_000  # trials or descents: the schema's limit of both
SUMMARY_FILE = "summary.txt"
COMPARISON_FILE = "comparison.csv"

T = TypeVar("T")


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
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say what would be run and about how long it takes.")
    ] = False,
    jobs: Jobs = ALL_CORES,
    dask: Dask = None,
    cache: CacheFolder = DEFAULT_CACHE,
    results: ResultsFolder = DEFAULT_RESULTS,
    as_json: Json = False,
) -> None:
    """Run every policy of an EXPERIMENT in every condition and compare their returns.

    Needs the reactions of `fatplan simulate`. Options restrict or change the experiment's grid; a
    changed grid gets a results folder of its own, named after the changes. An interrupted run goes on
    where it stopped when it is started again, and ends in the same table.
    """
    settings = load_experiment(experiment)
    wanted = Selection(cycles, conditions, policies, trials, descents, seed)
    asked = selected(settings, wanted)
    profiles = load_cycle_profiles(asked, cache, command_line("simulate", experiment, cache))
    left_out = omissions(asked, profiles)
    warn(left_out)
    grid = without_infeasible(asked, profiles)
    store = results / settings.name / "parts"
    grid_cells = cells(grid, profiles)
    if dry_run:
        plan = _plan(grid, grid_cells, store, jobs)
        present(plan, _plan_text(plan), as_json)
        return
    executor = executor_of(jobs, dask)
    folder = writable_folder(results / (settings.name + wanted.suffix()))
    writable_folder(store)
    judges = references(grid, grid_cells) if regret else {}
    done = _run(grid_cells, store, executor, f"Running {len(grid_cells)} cells", "runs")
    table = trial_table(grid_cells, done)
    assert not table[OUTCOMES].isna().any(axis=None)
    publish_table(folder, table, [TRIALS_FILE, ACTIONS_FILE, TIMES_FILE])
    comparison = comparison_table(table, settings.statistics.significance_level)
    publish_csv(folder / COMPARISON_FILE, comparison)
    contrasted = contrasts(table, grid.statistics, grid.benchmark.seed)
    publish_csv(folder / CONTRASTS_FILE, contrasted)
    summary = "".join(f"{sentence}\n" for sentence in left_out)
    summary += summary_text(comparison, settings.statistics.significance_level)
    summary += "\n" + contrast_text(contrasted, grid.statistics)
    files = [TRIALS_FILE, ACTIONS_FILE, COMPARISON_FILE, CONTRASTS_FILE, SUMMARY_FILE]
    regrets = gaps = None
    if regret:
        losses = _measure_regret(grid_cells, done, judges, store, executor)
        publish_table(folder, losses, [REGRET_FILE])
        names = {condition: describe(reference) for condition, reference in judges.items()}
        regrets = regret_table(table.merge(losses, on=KEY))
        summary += "\n" + regret_text(regrets, names)
        files.append(REGRET_FILE)
    if bound:
        gaps = gap_table(comparison, _run_bounds(grid_cells, results / settings.name / "bounds", executor))
        publish_bounds(folder, gaps)
        hidden = dict.fromkeys(cell.condition for cell in grid_cells if cell.scenario.prior is not None)
        summary += "\n" + gap_text(gaps, list(hidden))
        files.append(BOUNDS_FILE)
    for file in {REGRET_FILE, BOUNDS_FILE} - set(files):
        remove(folder / file)  # of an earlier run, perhaps with other settings
    publish_text(folder / SUMMARY_FILE, summary)
    configuration = {
        "experiment": asked.plain(),
        "actions": {cell.condition: cell.scenario.model.actions for cell in grid_cells},
        "seed": grid.benchmark.seed,
        "reactions": digests(reaction_requests(settings)),
        "references": {condition: reference.plain() for condition, reference in judges.items()},
    }
    hashes = publish_manifest(folder, "benchmark", configuration, [folder / name for name in files])
    others = ", ".join([*files[1:], TIMES_FILE, MANIFEST_FILE])
    document = BenchmarkRun(
        folder=folder,
        files=hashes,
        runs=len(table),
        comparison=records(comparison),
        regret=None if regrets is None else records(regrets),
        bounds=None if gaps is None else records(gaps),
    )
    present(document, f"{summary}\n{folder}: {TRIALS_FILE} ({len(table)} runs), {others}", as_json)


def _plan(experiment: Experiment, grid: Sequence[Cell], store: Path, jobs: int) -> BenchmarkPlan:
    """What would be run, what of it is there, and about how long the rest takes."""
    asked, left = experiment.benchmark, decisions_left(grid, store)
    return BenchmarkPlan(
        conditions=tuple(asked.conditions),
        n_cycles=asked.n_cycles,
        policies=tuple(asked.policies),
        cells=len(grid),
        runs=sum(len(cell.trial_numbers()) for cell in grid),
        decisions=sum(len(cell.trial_numbers()) * cell.n_cycles for cell in grid),
        decisions_left=sum(left),
        store=store,
        jobs=jobs,
        estimated_s=estimated_seconds(grid, left, jobs),
    )


def _plan_text(plan: BenchmarkPlan) -> str:
    lines = [
        f"conditions: {', '.join(plan.conditions)}",
        f"cycles: {', '.join(map(str, plan.n_cycles))}",
        f"policies: {', '.join(plan.policies)}",
        f"{counted(plan.cells, 'cell')}, {counted(plan.runs, 'run')}, {plan.decisions} decisions, "
        f"{plan.decisions_left} of them not in {plan.store} yet: about {duration_text(plan.estimated_s)} with "
        f"--jobs {plan.jobs} (regret and bounds not counted).",
    ]
    return "\n".join(lines)


def _measure_regret(
    grid: Sequence[Cell],
    done: Sequence[Mapping[int, TrialResult]],
    judges: Mapping[str, ReferenceSettings],
    store: Path,
    executor: Executor,
) -> pd.DataFrame:
    judgements = [
        RegretJob(cell, judges[cell.condition], {trial: result.actions for trial, result in runs.items()})
        for cell, runs in zip(grid, done, strict=True)
    ]
    return regret_rows(grid, _run(judgements, store, executor, "Measuring regret", "judged runs"))


def _run_bounds(cells: Sequence[Cell], store: Path, executor: Executor) -> pd.DataFrame:
    places = {(cell.condition, cell.n_cycles) for cell in cells if cell.scenario.prior is None}
    with progress("Bounding the least cost", len(places), kept=("bounds", store)) as counter:
        bounds, warnings = run_bounds(cells, writable_folder(store), executor, counter.advance)
    warn(warnings)
    return bounds


def _run(grid: Sequence[Job[T]], store: Path, executor: Executor, title: str, what: str) -> list[dict[int, T]]:
    runs = sum(len(job.trial_numbers()) for job in grid)
    effort = sum(len(job.trial_numbers()) * job.effort for job in grid)
    with progress(title, runs, effort, kept=(what, store)) as counter:
        done, warnings = run_grid(grid, store, executor, lambda job, n: counter.advance(n, n * job.effort))
    warn(warnings)
    return done

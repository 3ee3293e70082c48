"""`fatplan benchmark`: the grid of conditions, numbers of cycles and policies."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import run_jobs, warn
from fatigue_planner.core.text import counted

if TYPE_CHECKING:
    import pandas as pd

    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.experiment.statistics_settings import StatisticsSettings
    from fatigue_planner.planners.lookahead import ReferenceSettings
    from fatigue_planner.study.benchmark.cell import Cell
    from fatigue_planner.study.benchmark.selection import Selection
    from fatigue_planner.study.benchmark.trial import TrialResult

SUMMARY_FILE = "summary.txt"


def benchmark(
    experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT,
    cycles: options.Cycles = None,
    conditions: options.Conditions = None,
    policies: options.Policies = None,
    trials: options.Trials = None,
    descents: options.Descents = None,
    seed: options.Seed = None,
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
    jobs: options.Jobs = options.ALL_CORES,
    dask: options.Dask = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Run every policy of an EXPERIMENT in every condition and compare their returns.

    Needs the reactions of `fatplan simulate`. Options restrict or change the experiment's grid; a
    changed grid gets a results folder of its own, named after the changes. The same command continues
    an interrupted run where it stopped, and ends with the same tables.
    """
    from fatigue_planner.core.files import find_shipped, publish_bytes, writable_folder
    from fatigue_planner.experiment.build import load_cycle_profiles
    from fatigue_planner.experiment.feasibility import omissions, without_infeasible
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.study.benchmark.bounds import bound_jobs, bound_rows
    from fatigue_planner.study.benchmark.regret import RegretJob
    from fatigue_planner.study.benchmark.results import EXPERIMENT_FILE
    from fatigue_planner.study.benchmark.selection import Selection, cells, references, selected
    from fatigue_planner.study.benchmark.tables import regret_rows

    settings, content = load_experiment(experiment), find_shipped(experiment).read_bytes()
    wanted = Selection(cycles, conditions, policies, trials, descents, seed)
    asked = selected(settings, wanted)
    if bound:
        asked.cost.fatigue_cost().check_quadratic("--bound")
    profiles = load_cycle_profiles(asked, cache, options.command_line("simulate", experiment, cache))
    grid, left_out = (
        without_infeasible(asked, profiles, profiles.ruled_out),
        omissions(asked, profiles, profiles.ruled_out),
    )
    warn(left_out)
    store = results / settings.name / "parts"
    grid_cells = cells(grid, profiles)
    if dry_run:
        plan = _plan(grid, grid_cells, store, jobs)
        options.present(plan, _plan_text(plan), as_json)
        return
    executor = options.executor_of(jobs, dask)
    folder = writable_folder(results / (settings.name + wanted.suffix()))
    writable_folder(store)
    judges = references(grid, grid_cells) if regret else {}
    done = run_jobs(grid_cells, store, executor, f"Running {len(grid_cells)} cells", "runs")
    losses = bounds = None
    if regret:
        judgements = [
            RegretJob(cell, judges[cell.condition], {trial: result.actions for trial, result in runs.items()})
            for cell, runs in zip(grid_cells, done, strict=True)
        ]
        losses = regret_rows(grid_cells, run_jobs(judgements, store, executor, "Measuring regret", "judged runs"))
    if bound:
        asked_bounds, bound_store = bound_jobs(grid_cells), writable_folder(results / settings.name / "bounds")
        found = run_jobs(asked_bounds, bound_store, executor, "Bounding the least cost", "bounds")
        bounds = bound_rows(asked_bounds, found)
    publish_bytes(folder / EXPERIMENT_FILE, content)
    document, text = _publish(
        folder, asked, wanted, grid.statistics, left_out, grid_cells, done, judges, losses, bounds
    )
    options.present(document, text, as_json)


def _publish(
    folder: Path,
    experiment: "Experiment",
    selection: "Selection",
    statistics: "StatisticsSettings",
    left_out: Sequence[str],
    grid: "Sequence[Cell]",
    done: "Sequence[dict[int, TrialResult]]",
    judges: "Mapping[str, ReferenceSettings]",
    losses: "pd.DataFrame | None",
    bounds: "pd.DataFrame | None",
) -> tuple[dict[str, Any], str]:
    """Everything on disk; its JSON document, and its summary for people.

    `experiment` is what was asked for; statistics and grid are of what of it can be performed.
    Regret and bounds of an earlier run stay if they belong to these runs; else it is said that they go.
    """
    from fatigue_planner.core.files import publish_text
    from fatigue_planner.core.provenance import MANIFEST_FILE
    from fatigue_planner.experiment.build import reaction_requests
    from fatigue_planner.planners.lookahead import describe
    from fatigue_planner.reactions.reaction import digests
    from fatigue_planner.study.benchmark import results, tables
    from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE, publish_bounds, read_bounds
    from fatigue_planner.study.benchmark.comparisons import publish_comparisons
    from fatigue_planner.study.statistics.comparison import summary_text
    from fatigue_planner.study.statistics.contrast import contrast_text
    from fatigue_planner.study.statistics.pairing import records
    from fatigue_planner.study.statistics.regret import gap_table, gap_text, regret_table, regret_text

    table = tables.trial_table(grid, done)
    assert not table[tables.OUTCOMES].isna().any(axis=None)
    tables.publish_table(folder, table, [tables.TRIALS_FILE, tables.ACTIONS_FILE, tables.TIMES_FILE])
    comparison, contrasted = publish_comparisons(folder, table, statistics, experiment.benchmark.seed)
    summary = "".join(f"{sentence}\n" for sentence in left_out)
    summary += summary_text(comparison, statistics.significance_level) + "\n" + contrast_text(contrasted, statistics)
    files = [tables.TRIALS_FILE, tables.ACTIONS_FILE, results.COMPARISON_FILE, results.CONTRASTS_FILE, SUMMARY_FILE]
    asked = {tables.REGRET_FILE: losses is not None, BOUNDS_FILE: bounds is not None}
    kept, warnings = results.keep_or_remove(experiment, folder, [file for file, wanted in asked.items() if not wanted])
    if losses is not None:
        tables.publish_table(folder, losses, [tables.REGRET_FILE])
    elif tables.REGRET_FILE in kept:
        losses, judges = tables.read_table(folder, tables.REGRET_FILE, ""), kept[tables.REGRET_FILE].references
    regrets = gaps = None
    if losses is not None:
        regrets = regret_table(table.merge(losses, on=tables.KEY))
        summary += "\n" + regret_text(regrets, {name: describe(reference) for name, reference in judges.items()})
        files.append(tables.REGRET_FILE)
    if bounds is not None:
        gaps = gap_table(comparison, bounds)
        publish_bounds(folder, gaps)
    elif BOUNDS_FILE in kept:
        gaps = read_bounds(folder, "")
    if gaps is not None:
        hidden = dict.fromkeys(cell.condition for cell in grid if cell.scenario.prior is not None)
        summary += "\n" + gap_text(gaps, list(hidden))
        files.append(BOUNDS_FILE)
    publish_text(folder / SUMMARY_FILE, summary)
    configuration = {
        "experiment": experiment.plain(),
        "actions": {cell.condition: cell.scenario.model.actions for cell in grid},
        "selection": asdict(selection),
        "seed": experiment.benchmark.seed,
        "reactions": digests(reaction_requests(experiment)),
        "references": {condition: reference.plain() for condition, reference in judges.items()},
    }
    files.append(results.EXPERIMENT_FILE)
    hashes = _note(folder, configuration, files)
    warn(warnings)
    document = {
        "folder": folder,
        "files": hashes,
        "runs": len(table),
        "comparison": records(comparison),
        "regret": records(regrets) if asked[tables.REGRET_FILE] and regrets is not None else None,
        "bounds": records(gaps) if asked[BOUNDS_FILE] and gaps is not None else None,
    }
    others = ", ".join([*files[1:], tables.TIMES_FILE, MANIFEST_FILE])
    return document, f"{summary}\n{folder}: {tables.TRIALS_FILE} ({len(table)} runs), {others}"


def _note(folder: Path, configuration: Mapping[str, Any], files: Sequence[str]) -> dict[str, str]:
    """Publish the manifest; say what other commands have made of tables that are others now."""
    from fatigue_planner.core.errors import listed
    from fatigue_planner.core.provenance import noted_files, publish_manifest

    earlier = noted_files(folder)
    hashes = publish_manifest(folder, "benchmark", configuration, [folder / name for name in files])
    own = earlier.pop("benchmark", {})
    if earlier and any(hashes.get(file) != digest for file, digest in own.items()):
        commands = listed(f"`fatplan {command}`" for command in sorted(earlier))
        warn([f"{folder}: what {commands} made there is of the earlier tables."])
    return hashes


def _plan(experiment: "Experiment", grid: "Sequence[Cell]", store: Path, jobs: int) -> dict[str, Any]:
    """The JSON document of what would be run, what of it is stored already, and about how long the rest takes."""
    from fatigue_planner.study.benchmark.estimate import decisions_left, estimated_seconds

    asked, left = experiment.benchmark, decisions_left(grid, store)
    return {
        "conditions": tuple(asked.conditions),
        "n_cycles": asked.n_cycles,
        "policies": tuple(asked.policies),
        "cells": len(grid),
        "runs": sum(len(cell.trial_numbers()) for cell in grid),
        "decisions": sum(len(cell.trial_numbers()) * cell.n_cycles for cell in grid),
        "decisions_left": sum(left),
        "store": store,
        "jobs": jobs,
        "estimated_s": estimated_seconds(grid, left, jobs),
    }


def _plan_text(plan: Mapping[str, Any]) -> str:
    from fatigue_planner.study.benchmark.estimate import duration_text

    lines = [
        f"conditions: {', '.join(plan['conditions'])}",
        f"cycles: {', '.join(map(str, plan['n_cycles']))}",
        f"policies: {', '.join(plan['policies'])}",
        f"{counted(plan['cells'], 'cell')}, {counted(plan['runs'], 'run')}, {plan['decisions']} decisions, "
        f"{plan['decisions_left']} of them not in {plan['store']} yet: about {duration_text(plan['estimated_s'])} with "
        f"--jobs {plan['jobs']} (regret and bounds not counted).",
    ]
    return "\n".join(lines)

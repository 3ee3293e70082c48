"""`fatplan benchmark`: the grid of conditions, numbers of cycles and policies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
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
    choose,
    command_line,
    counter,
    talk,
)
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import load_cycle_profiles, reaction_requests, situation
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.cycle_map import CycleProfile
from fatigue_planner.files import DIGEST_LENGTH, digest_of, publish_text, writable_folder
from fatigue_planner.planners.reference import describe, reference_for
from fatigue_planner.planners.settings import LookaheadSettings, PomcpSettings
from fatigue_planner.provenance import MANIFEST_FILE, publish_manifest
from fatigue_planner.reactions.reaction import ReactionName, digests
from fatigue_planner.statistics.comparison import comparison_table
from fatigue_planner.statistics.gaps import gap_table, gap_text
from fatigue_planner.statistics.regret import regret_table, regret_text
from fatigue_planner.statistics.summary import summary_text

MOST = 1_000_000  # trials or descents: the schema's limit of both
LONGEST_SUFFIX = 120  # file systems end at 255
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
    grid = _changed(settings, wanted)
    profiles = load_cycle_profiles(settings, cache, command_line("simulate", experiment, cache))
    store = writable_folder(results / settings.name / "parts")
    folder = writable_folder(results / (settings.name + _suffix(wanted)))
    cells = _cells(grid, profiles, wanted.regret)
    table = _run(cells, store, jobs)
    publish_table(folder, table)
    comparison = comparison_table(table, settings.significance_level)
    publish_text(folder / COMPARISON_FILE, comparison.to_csv(index=False, lineterminator="\n"))
    summary = summary_text(comparison, settings.significance_level)
    files = [TRIALS_FILE, COMPARISON_FILE, SUMMARY_FILE]
    if regret:
        summary += "\n" + _regret_summary(cells, table)
        files.append(REGRET_FILE)
    if bound:
        gaps = gap_table(comparison, _run_bounds(cells, results / settings.name / "bounds", jobs))
        publish_bounds(folder, gaps)
        summary += "\n" + gap_text(gaps)
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


@dataclass(frozen=True)
class Selection:
    """What the options ask of the grid; None leaves it as it is in the file."""

    cycles: Sequence[int] | None
    conditions: Sequence[str] | None
    policies: Sequence[str] | None
    trials: int | None
    descents: int | None
    seed: int | None
    regret: bool


def _changed(experiment: Experiment, wanted: Selection) -> Experiment:
    """The experiment with the grid the options ask for. Raises SelectionError for unknown names."""
    grid = experiment.benchmark
    chosen_policies = {name: grid.policies[name] for name in choose("policies", list(grid.policies), wanted.policies)}
    if wanted.descents is not None:
        chosen_policies = {
            name: policy.model_copy(update={"descents": wanted.descents, "seconds": None})
            if isinstance(policy, PomcpSettings)
            else policy
            for name, policy in chosen_policies.items()
        }
    chosen_conditions = choose("conditions", list(grid.conditions), wanted.conditions)
    changes = {
        "n_cycles": tuple(choose("cycles", grid.n_cycles, wanted.cycles)),
        "conditions": {name: grid.conditions[name] for name in chosen_conditions},
        "policies": chosen_policies,
        "trials": wanted.trials or grid.trials,
        "seed": grid.seed if wanted.seed is None else wanted.seed,
    }
    return experiment.model_copy(update={"benchmark": grid.model_copy(update=changes)})


def _suffix(wanted: Selection) -> str:
    """How a changed grid's results folder differs in name, e.g. `_cycles-100_trials-3`."""
    lists: dict[str, Sequence[object] | None] = {
        "cycles": wanted.cycles, "conditions": wanted.conditions, "policies": wanted.policies
    }  # fmt: skip
    numbers = {"trials": wanted.trials, "descents": wanted.descents, "seed": wanted.seed}
    parts = [f"_{name}-{'+'.join(sorted(set(map(str, items))))}" for name, items in lists.items() if items]
    parts += [f"_{name}-{number}" for name, number in numbers.items() if number is not None]
    parts += ["_regret"] if wanted.regret else []
    suffix = "".join(parts)
    return suffix if len(suffix) <= LONGEST_SUFFIX else f"_selection-{digest_of(suffix)[:DIGEST_LENGTH]}"


def _cells(experiment: Experiment, profiles: Mapping[ReactionName, CycleProfile], with_regret: bool) -> list[Cell]:
    grid = experiment.benchmark
    situations = {name: situation(experiment, profiles, condition) for name, condition in grid.conditions.items()}
    references: dict[str, LookaheadSettings | None] = dict.fromkeys(situations)
    if with_regret:
        references = {
            name: grid.reference or reference_for(one.initial_belief("prior", one.model, np.random.default_rng(0)))
            for name, one in situations.items()
        }
    return [
        Cell(
            condition, n_cycles, policy, settings, situations[condition], grid.seed, grid.trials, references[condition]
        )
        for condition in grid.conditions
        for n_cycles in grid.n_cycles
        for policy, settings in grid.policies.items()
    ]


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

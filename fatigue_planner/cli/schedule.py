"""`fatplan schedule`: the best rotation for one worker or several, without a robot that plans."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import run_jobs, warn
from fatigue_planner.core.errors import SelectionError

if TYPE_CHECKING:
    from fatigue_planner.experiment.schema import Experiment
    from fatigue_planner.study.schedule import Rotation, Worth

MAX_CYCLES = 100_000
# How many joints the text and the card name.
NAMED_JOINTS = 3
# How many conditions the card has room for.
NAMED_CONDITIONS = 6
CARD = "schedule_card"


def schedule(
    experiment: options.ExperimentFile = options.DEFAULT_EXPERIMENT,
    conditions: options.Conditions = None,
    cycles: Annotated[
        int | None, typer.Option(min=1, max=MAX_CYCLES, help="Length of the task; default: the file's longest.")
    ] = None,
    longest: Annotated[int, typer.Option(min=1, max=8, help="The most steps of the schedule.")] = 8,
    trials: options.Trials = None,
    seed: options.Seed = None,
    bound: Annotated[
        bool, typer.Option("--bound", help="Also compute a cost that no policy can beat (known workers).")
    ] = False,
    jobs: options.Jobs = options.ALL_CORES,
    dask: options.Dask = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    plugins: options.Plugins = None,
    as_json: options.Json = False,
) -> None:
    """Find the best rotation for an EXPERIMENT: a sequence of actions that is repeated, whatever the worker does.

    It is one schedule for the workers of all conditions, or of those that --conditions names. Every worker's cost is
    compared with that of the best fixed action, of greedy and of exact planning, by runs with common random numbers.
    Needs the reactions of `fatplan simulate`. A card to print goes to the results folder (PNG, SVG).
    """
    from fatigue_planner.core.files import writable_folder
    from fatigue_planner.experiment.build import load_cycle_profiles, scenario
    from fatigue_planner.experiment.feasibility import omissions, without_infeasible
    from fatigue_planner.experiment.loader import load_experiment
    from fatigue_planner.study.benchmark.bounds import bound_jobs, bound_rows
    from fatigue_planner.study.benchmark.selection import Selection, selected
    from fatigue_planner.study.schedule import find_rotation, rotation_cells, worth_of

    settings = load_experiment(experiment)
    if settings.discount == 1:
        raise SelectionError(f"{experiment}: discount = 1: a schedule repeats for ever; it needs a discount below 1.")
    asked = selected(settings, Selection(conditions=conditions, trials=trials, seed=seed))
    simulate = options.command_line("simulate", experiment, cache)
    profiles = load_cycle_profiles(asked, cache, simulate)
    grid = without_infeasible(asked, profiles)
    warn(omissions(asked, profiles))
    scenarios = {name: scenario(grid, profiles, condition) for name, condition in grid.benchmark.conditions.items()}
    executor = options.executor_of(jobs, dask)
    rotation = find_rotation(scenarios, longest)
    n_cycles = cycles or max(grid.benchmark.n_cycles)
    cells = rotation_cells(scenarios, rotation.actions, n_cycles, grid.benchmark.seed, grid.benchmark.trials)
    folder = writable_folder(results / settings.name / "schedule")
    store = writable_folder(results / settings.name / "parts")
    done = run_jobs(cells, store, executor, "Comparing the schedule", "runs")
    bounds = {}
    if bound:
        asked_bounds, bound_store = bound_jobs(cells), writable_folder(results / settings.name / "bounds")
        bounded = bound_rows(
            asked_bounds, run_jobs(asked_bounds, bound_store, executor, "Bounding the least cost", "bounds")
        )
        bounds = dict(zip(bounded["condition"], bounded["cost_bound"].tolist(), strict=True))
    found = worth_of(cells, done, grid.statistics, longest)
    lines = _text(rotation, found, bounds, n_cycles)
    files = _draw_card(grid, folder, cache, simulate, rotation, found, n_cycles)
    document = {
        "schedule": rotation.actions,
        "exact": rotation.exact,
        "n_cycles": n_cycles,
        "trials": grid.benchmark.trials,
        "conditions": [_entry(rotation, worth, bounds) for worth in found],
        "folder": folder,
        "files": files,
    }
    options.present(document, "\n".join([*lines, f"{folder}: {', '.join(path.name for path in files)}"]), as_json)


def _entry(rotation: "Rotation", worth: "Worth", bounds: Mapping[str, float]) -> dict[str, Any]:
    """A condition in the JSON document."""
    own, loss = rotation.own[worth.condition]
    least = bounds.get(worth.condition)
    return {
        "condition": worth.condition,
        "cost": worth.cost,
        "standard_error": worth.standard_error,
        "own_schedule": own,
        "loss_to_own_schedule": loss,
        "best_fixed": worth.best_fixed,
        "savings": [asdict(saving) for saving in worth.savings.values()],
        "cost_bound": least,
        "gap_to_bound": None if least is None else worth.cost / least - 1,
        "peak_fatigue": {
            entry: {"best_fixed": fixed, "schedule": own_peak} for entry, (fixed, own_peak) in worth.spared.items()
        },
        "loss_if_misjudged": worth.misjudged,
    }


def _text(rotation: "Rotation", found: "Sequence[Worth]", bounds: Mapping[str, float], n_cycles: int) -> list[str]:
    from fatigue_planner.core.text import format_label, listing, percent, significant
    from fatigue_planner.study.schedule import BEST_FIXED, ERGONOMIC, GREEDY, PLANNING

    how = "the best of all that are no longer" if rotation.exact else "found by search"
    lines = [f"Schedule, repeated for ever: {', '.join(rotation.actions)} ({how})."]
    for worth in found:
        own, loss = rotation.own[worth.condition]
        saved = worth.savings
        lines += [
            "",
            f"{format_label(worth.condition)}, {n_cycles} cycles: mean discounted cost {significant(worth.cost, 5)}"
            + (f" ± {significant(worth.standard_error, 2)} (standard error)" if worth.standard_error else ""),
            *(
                f"  costs {saved[other].compared(what)}"
                for other, what in (
                    (BEST_FIXED, f"always {worth.best_fixed}, the best fixed action"),
                    (ERGONOMIC, "the action that is most ergonomic in one cycle, for ever"),
                    (GREEDY, "greedy"),
                    (PLANNING, "exact planning in every cycle (what closing the loop is worth)"),
                )
            ),
        ]
        if worth.condition in bounds:
            least = bounds[worth.condition]
            error = f" ± {percent(worth.standard_error / least)}" if worth.standard_error else ""
            lines.append(f"  costs {percent(worth.cost / least - 1)}{error} more than the bound no policy can beat")
        if loss > 0:
            lines.append(f"  costs {percent(loss)} more than this worker's own best schedule, {', '.join(own)}")
        spared = _spared_joints(worth)
        lines.append(f"  spares (highest fatigue) {listing(spared)}" if spared else "  spares no joint")
        lines.append("  costs more than the best schedule for a worker who is not as assumed, but who")
        worst = sorted(worth.misjudged.items(), key=lambda item: -item[1])
        lines += [f"    {name}: {percent(share)}" for name, share in worst]
    return lines


def _spared_joints(worth: "Worth") -> list[str]:
    """The entries whose peak fatigue falls most, with both peaks in per cent of the strength."""
    from fatigue_planner.core.text import format_label, percent

    falls = [(entry, fixed, own) for entry, (fixed, own) in worth.spared.items() if own < fixed]
    return [
        f"{format_label(entry)} ({percent(fixed, 0)} → {percent(own, 0)})" for entry, fixed, own in falls[:NAMED_JOINTS]
    ]


def _draw_card(
    grid: "Experiment",
    folder: Path,
    cache: Path,
    simulate: str,
    rotation: "Rotation",
    found: "Sequence[Worth]",
    n_cycles: int,
) -> list[Path]:
    """The card for the first condition's worker."""
    from fatigue_planner.core.text import counted, format_label, listing, percent
    from fatigue_planner.experiment.build import reaction_requests
    from fatigue_planner.human.model import build_human
    from fatigue_planner.output.figures.schedule_card import schedule_card
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.reactions.reaction import Reaction
    from fatigue_planner.study.schedule import BEST_FIXED, PLANNING

    conditions = grid.benchmark.conditions
    worker = grid.worker_of(conditions[found[0].condition])
    shown = next(iter(grid.preferences))
    requests = [
        request
        for request in reaction_requests(grid)
        if request.name.worker == worker
        and request.name.preference == shown
        and request.name.action in rotation.actions
    ]
    reactions = [one for one in ReactionCache(cache).stream(requests, simulate) if isinstance(one, Reaction)]
    notes = [
        f"{counted(len(rotation.actions), 'step')}, one per cycle, then from 1 again. Drawn: {format_label(worker)}, "
        f"{format_label(shown)} reaction."
    ]
    for worth in found[:NAMED_CONDITIONS]:
        saved, more = worth.savings[BEST_FIXED], worth.savings[PLANNING].turned()
        planned = f"{percent(more.share, 1)} more than with a robot that plans"
        if more.share <= 0 or more.low < 0:
            planned = "as much as with a robot that plans, within chance"
        line = (
            f"{format_label(worth.condition).capitalize()}: {percent(saved.share, 0)} less fatigue (cost of {n_cycles} "
            f"cycles) than always {format_label(worth.best_fixed)}; {planned}"
        )
        spared = _spared_joints(worth)
        notes.append(
            f"{line}. Spares (highest fatigue) {listing(spared)}." if spared and len(found) == 1 else f"{line}."
        )
    if len(found) > NAMED_CONDITIONS:
        notes.append(f"And {counted(len(found) - NAMED_CONDITIONS, 'other condition')}.")
    figures = FigureFolder(folder)
    title = f"{format_label(grid.name)}: one step per cycle, in this order"
    figure, steps = schedule_card(
        title, rotation.actions, grid.actions, build_human(grid.workers[worker]), reactions, notes
    )
    figures.add(CARD, figure, steps)
    return figures.files

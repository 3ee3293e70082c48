"""`fatplan schedule`: the best rotation for one worker or several, without a robot that plans."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import run_jobs, warn

if TYPE_CHECKING:
    from fatigue_planner.cli.scheduled import Scheduled
    from fatigue_planner.study.schedule import Rotation, Worth

MAX_CYCLES = 100_000
# How many joints the text and the card name.
NAMED_JOINTS = 3
# How many conditions the card has room for.
NAMED_CONDITIONS = 6
CARD = "schedule_card"


def schedule(
    experiment: Annotated[
        Path,
        typer.Argument(
            metavar="EXPERIMENT", help="The experiment or the station (YAML), or the name of one that ships."
        ),
    ] = options.DEFAULT_EXPERIMENT,
    conditions: Annotated[
        list[str] | None, typer.Option(help="Only this condition, or this worker of a station (repeatable).")
    ] = None,
    cycles: Annotated[
        int | None,
        typer.Option(min=1, max=MAX_CYCLES, help="Length of the task; default: the file's longest; of a station, 100."),
    ] = None,
    longest: Annotated[
        int | None, typer.Option(min=1, max=8, help="The most steps of the schedule; default: 8; of a station, 6.")
    ] = None,
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

    Of a station: a sequence of its places that are allowed, each worker in the way that is best there. What is missing
    is simulated.
    """
    from fatigue_planner.cli.scheduled import scheduled_experiment, scheduled_station
    from fatigue_planner.core.errors import ExperimentError
    from fatigue_planner.core.file_kinds import FileKind, kind_of
    from fatigue_planner.core.files import find_shipped, writable_folder
    from fatigue_planner.core.yaml_reader import read_yaml
    from fatigue_planner.study.benchmark.bounds import bound_jobs, bound_rows
    from fatigue_planner.study.benchmark.selection import Selection
    from fatigue_planner.study.schedule import find_rotation, rotation_cells, worth_of

    wanted, executor = Selection(conditions=conditions, trials=trials, seed=seed), options.executor_of(jobs, dask)
    if kind_of(read_yaml(find_shipped(experiment), ExperimentError)) is FileKind.STATION:
        task = scheduled_station(experiment, wanted, cache, executor)
    else:
        task = scheduled_experiment(experiment, wanted, cache)
        warn(task.left_out)
    rotation = find_rotation(task.scenarios, longest or task.longest)
    n_cycles = cycles or task.n_cycles
    cells = rotation_cells(task.scenarios, rotation.actions, n_cycles, task.seed, task.trials)
    folder = writable_folder(results / task.name / "schedule")
    store = writable_folder(results / task.name / "parts")
    done = run_jobs(cells, store, executor, "Comparing the schedule", "runs")
    bounds = {}
    if bound:
        asked_bounds, bound_store = bound_jobs(cells), writable_folder(results / task.name / "bounds")
        bounded = bound_rows(
            asked_bounds, run_jobs(asked_bounds, bound_store, executor, "Bounding the least cost", "bounds")
        )
        bounds = dict(zip(bounded["condition"], bounded["cost_bound"].tolist(), strict=True))
    found = worth_of(cells, done, task.statistics, longest or task.longest)
    lines = _text(task, rotation, found, bounds, n_cycles)
    files = _draw_card(task, folder, rotation, found, n_cycles)
    document = {
        "schedule": rotation.actions,
        "exact": rotation.exact,
        "n_cycles": n_cycles,
        "trials": task.trials,
        "places": [task.places[action] for action in rotation.actions if task.places],
        "left_out": task.left_out,
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


def _text(
    task: "Scheduled", rotation: "Rotation", found: "Sequence[Worth]", bounds: Mapping[str, float], n_cycles: int
) -> list[str]:
    from fatigue_planner.core.text import format_label, listing, percent, significant
    from fatigue_planner.study.schedule import BEST_FIXED, ERGONOMIC, GREEDY, PLANNING

    how = "the best of all that are no longer" if rotation.exact else "found by search"
    lines = [f"Schedule, repeated for ever: {', '.join(rotation.actions)} ({how})."]
    if any(len(places) > 1 for places in task.places.values()):
        for action in dict.fromkeys(rotation.actions):
            at = listing([f"{operation} at {place}" for operation, place in task.places[action].items()])
            lines.append(f"  {action} is {at}.")
    lines += [f"  {reason}." for reason in task.left_out]
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
                    (BEST_FIXED, f"always {worth.best_fixed}, the best fixed {task.choice}"),
                    (ERGONOMIC, f"the {task.choice} that is most ergonomic in one cycle, for ever"),
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
    task: "Scheduled", folder: Path, rotation: "Rotation", found: "Sequence[Worth]", n_cycles: int
) -> list[Path]:
    """The card for the first condition's worker."""
    from fatigue_planner.core.text import counted, format_label, listing, percent
    from fatigue_planner.output.figures.schedule_card import schedule_card
    from fatigue_planner.output.figures.style import FigureFolder
    from fatigue_planner.study.schedule import BEST_FIXED, PLANNING

    drawn = task.drawn(rotation.actions)
    notes = [f"{counted(len(rotation.actions), 'step')}, one per cycle, then from 1 again. Drawn: {drawn.label}."]
    for worth in found[:NAMED_CONDITIONS]:
        saved, more = worth.savings[BEST_FIXED], worth.savings[PLANNING].turned()
        planned = f"{percent(more.share, 1)} more than with a robot that plans"
        if more.share <= 0 or more.low < 0:
            planned = "as much as with a robot that plans, within chance"
        line = (
            f"{task.labels[worth.condition]}: {percent(abs(saved.share), 0)} {'more' if saved.share < 0 else 'less'} "
            f"fatigue (cost of {n_cycles} cycles) than always {format_label(worth.best_fixed)}; {planned}"
        )
        spared = _spared_joints(worth)
        notes.append(
            f"{line}. Spares (highest fatigue) {listing(spared)}." if spared and len(found) == 1 else f"{line}."
        )
    if len(found) > NAMED_CONDITIONS:
        notes.append(f"And {counted(len(found) - NAMED_CONDITIONS, 'other condition')}.")
    figures = FigureFolder(folder)
    title = f"{format_label(task.name)}: one step per cycle, in this order"
    figure, steps = schedule_card(title, rotation.actions, drawn.human, drawn.steps, notes)
    figures.add(CARD, figure, steps)
    return figures.files

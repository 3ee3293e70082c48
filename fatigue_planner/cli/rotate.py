"""`fatplan rotate`: who works where in which slot of a shift."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fatigue_planner.cli import options
from fatigue_planner.cli.progress import progress, warn

if TYPE_CHECKING:
    from fatigue_planner.station.line.rotate import CrewRotation

FREE_WORD = "free"


def rotate(
    line: Annotated[Path, typer.Argument(metavar="LINE", help="The line's file (YAML).")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Folder of the results of this line.")
    ] = None,
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    jobs: options.Jobs = options.ALL_CORES,
    as_json: options.Json = False,
) -> None:
    """Say who of a crew works at which station of a LINE in which slot, and what that gains.

    Least is first the largest ratio of load to acceptable load of any worker, then the sum of the squares of all, then
    the number of changes. The measures remember the hours of a shift. Files in the results folder: rotation.json and
    rota.csv.
    """
    import pandas as pd

    from fatigue_planner.core.files import publish_csv, publish_text, writable_folder
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.station.line.loader import load_line
    from fatigue_planner.station.line.rotate import motions_of, rotation_of

    loaded, executor, store = load_line(line), options.executor_of(jobs, None), ReactionCache(cache)
    folder = writable_folder(output or results / loaded.line.name)
    tasks = motions_of(loaded)
    motions = sum(map(len, tasks))
    command = options.command_line("rotate", line, cache, results)
    with progress("Simulating", motions, motions, kept=("motions", cache)) as counter:
        found = rotation_of(loaded, tasks, store, executor, command, lambda made: counter.advance(pieces=made.kept))
    warn(store.damaged)
    document = _document(found)
    files = [folder / "rotation.json", folder / "rota.csv"]
    publish_text(files[0], options.json_text(document) + "\n")
    publish_csv(files[1], pd.DataFrame(document["rota"], columns=["worker", "slot", "station"]))
    text = "\n".join([*_text(found), "", f"{folder}: {', '.join(file.name for file in files)}"])
    options.present(document | {"files": files}, text, as_json)


def _document(found: "CrewRotation") -> dict[str, Any]:
    line, advice = found.line.line, found.advice
    stations = list(line.stations)
    document: dict[str, Any] = {"line": line.plain(), "cannot": found.cannot, "rota": [], "advice": None}
    if advice is None:
        return document
    best = advice.best
    document["rota"] = [
        {"worker": worker, "slot": slot + 1, "station": found.place(number, slot)}
        for number, worker in enumerate(line.crew)
        for slot in range(line.slots)
    ]
    document["advice"] = {
        "largest": best.largest, "largest_bound": best.burden_bound, "fairness": best.fairness,
        "fairness_bound": best.fairness_bound, "changes": best.changes, "changes_bound": best.changes_bound,
        "exact": best.exact, "staying": advice.staying, "usual": advice.usual, "helps": advice.helps,
        "too_much": [stations[number] for number in advice.too_much],
        "redesign": None if advice.redesign is None else stations[advice.redesign[0]],
        "largest_after_redesign": None if advice.redesign is None else advice.redesign[1],
        "ratios": found.ratios, "without_pause": found.pauses,
    }  # fmt: skip
    return document


def _text(found: "CrewRotation") -> list[str]:
    line, advice = found.line.line, found.advice
    stations = list(line.stations)
    lines = [f"{line.name}: {line.slots} slots of {line.slot_s / 60:.0f} min of work; measure: {line.measure}"]
    lines += [
        f"  {worker} cannot or may not work at {', '.join(where)}." for worker, where in found.cannot.items() if where
    ]
    if advice is None:
        return [*lines, "  The stations cannot be manned all the time by those who can work at them."]
    best = advice.best
    shown = [[worker, *(found.place(number, slot) or FREE_WORD for slot in range(line.slots))]
             for number, worker in enumerate(line.crew)]  # fmt: skip
    widths = [max(map(len, column)) for column in zip(*shown, strict=True)]
    lines += [
        "  " + "  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip() for row in shown
    ]
    lines += [f"  Largest load over acceptable load of a worker: {best.largest:.2f}, with {best.changes} changes."]
    if not best.exact:
        lines += [
            f"  Not proven to be the least; nothing is below {best.burden_bound:.2f} and {best.changes_bound} changes."
        ]
    if advice.staying is not None:
        lines += [f"  If everybody stays where that is best: {advice.staying:.2f}."]
    usual = "sends somebody where he or she cannot work" if advice.usual is None else f"{advice.usual:.2f}"
    lines += [f"  Every hour to the next station: {usual}."]
    if not advice.helps:
        where = [stations[number] for number in advice.too_much]
        if not where and advice.redesign is not None:
            where = [stations[advice.redesign[0]]]
        lines += ["  Rotation does not help" + (f"; redesign {', '.join(where)}." if where else ".")]
    elif advice.redesign is not None:
        lines += [
            f"  More than is acceptable; without the load of {stations[advice.redesign[0]]}: {advice.redesign[1]:.2f}."
        ]
    lines += [
        f"  Without the pause at {pause.at_min:g} min, worked through: {100 * worth:+.0f} %."
        for pause, worth in zip(line.shift.breaks, found.pauses, strict=True)
    ]
    return [*lines, "  These measures remember hours; the fatigue laws of Ma and 3CC-r forget within minutes."]

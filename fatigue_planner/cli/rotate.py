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
    line: Annotated[
        Path, typer.Argument(metavar="LINE", help="The line's file (YAML), or the name of one that ships.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="DIR", help="Folder of the results of this line.")
    ] = None,
    language: options.PageLanguage = "en",
    cache: options.CacheFolder = options.DEFAULT_CACHE,
    results: options.ResultsFolder = options.DEFAULT_RESULTS,
    jobs: options.Jobs = options.ALL_CORES,
    as_json: options.Json = False,
) -> None:
    """Say who of a crew works at which station of a LINE in which slot, and what that gains.

    Least is first the largest ratio of load to acceptable load of any worker, then the sum of the squares of all, then
    the number of changes. The measures remember the hours of a shift. Files in the results folder: rota.html, a page to
    hang up; rotation.json and rota.csv. `fatplan init --line NAME` writes a line to fill in.
    """
    import pandas as pd

    from fatigue_planner.core.files import publish_csv, publish_text, writable_folder
    from fatigue_planner.output.reports.station.catalogue import catalogue_of
    from fatigue_planner.output.reports.station.rota import PAGE, rota_page
    from fatigue_planner.reactions.cache import ReactionCache
    from fatigue_planner.station.line.loader import load_line
    from fatigue_planner.station.line.rotate import motions_of, rotation_of

    texts = catalogue_of(language)
    loaded, executor, store = load_line(line), options.executor_of(jobs, None), ReactionCache(cache)
    folder = writable_folder(output or results / loaded.line.name)
    tasks = motions_of(loaded)
    motions = sum(map(len, tasks))
    command = options.command_line("rotate", line, cache, results)
    with progress("Simulating", motions, motions, kept=("motions", cache)) as counter:
        found = rotation_of(loaded, tasks, store, executor, command, lambda made: counter.advance(pieces=made.kept))
    warn(store.damaged)
    document = _document(found)
    files = [folder / PAGE, folder / "rotation.json", folder / "rota.csv"]
    publish_text(files[0], rota_page(found, texts))
    publish_text(files[1], options.json_text(document) + "\n")
    publish_csv(files[2], pd.DataFrame(document["rota"], columns=["worker", "slot", "from_min", "to_min", "station"]))
    text = "\n".join([*_text(found), "", f"{folder}: {', '.join(file.name for file in files)}"])
    options.present(document | {"files": files}, text, as_json)


def _document(found: "CrewRotation") -> dict[str, Any]:
    from fatigue_planner.station.line import statements
    from fatigue_planner.station.tables import plain

    line, advice = found.line.line, found.advice
    stations = list(line.stations)
    document: dict[str, Any] = {
        "line": line.plain(), "cannot": {worker: _reasons(found, worker) for worker in line.crew},
        "not_acceptable": list(map(str, statements.of_posts(found))), "rota": [], "advice": None,
    }  # fmt: skip
    if advice is None:
        return document
    best = advice.best
    times = [(spans[0][0], spans[-1][1]) for spans in line.slot_times()]
    document["rota"] = [
        {"worker": worker, "slot": slot + 1, "from_min": times[slot][0], "to_min": times[slot][1],
         "station": found.place(number, slot)}
        for number, worker in enumerate(line.crew)
        for slot in range(line.slots)
    ]  # fmt: skip
    document["advice"] = {
        "largest": best.largest, "largest_bound": best.burden_bound, "fairness": best.fairness,
        "fairness_bound": best.fairness_bound, "changes": best.changes, "changes_bound": best.changes_bound,
        "exact": best.exact, "staying": advice.staying, "usual": advice.usual, "helps": advice.helps,
        "too_much": [stations[number] for number in advice.too_much],
        "redesign": None if advice.redesign is None else stations[advice.redesign[0]],
        "largest_after_redesign": None if advice.redesign is None else advice.redesign[1],
        "ratios": found.ratios, "without_pause": found.pauses,
        "lifting": {worker: plain(each) for worker, each in found.lifting.items()},
    }  # fmt: skip
    return document


def _reasons(found: "CrewRotation", worker: str) -> dict[str, list[str]]:
    from fatigue_planner.station.line.statements import STATED_NOT

    return {
        station: list(map(str, found.posts[worker][station].why_not)) or [STATED_NOT]
        for station in found.cannot[worker]
    }


def _text(found: "CrewRotation") -> list[str]:
    from fatigue_planner.ergonomics.result import Phrase
    from fatigue_planner.station.line import statements

    line = found.line.line
    lines = [f"{line.name}: {line.slots} slots of {line.slot_s / 60:.0f} min of work; measure: {line.measure}"]
    lines += [
        f"  {worker} does not work at {station}: {'; '.join(reasons)}."
        for worker in line.crew
        for station, reasons in _reasons(found, worker).items()
    ]
    if found.advice is not None:
        shown = [[worker, *(found.place(number, slot) or FREE_WORD for slot in range(line.slots))]
                 for number, worker in enumerate(line.crew)]  # fmt: skip
        widths = [max(map(len, column)) for column in zip(*shown, strict=True)]
        lines += [
            "  " + "  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip()
            for row in shown
        ]
    said = [*statements.of_gain(found), *statements.of_redesign(found), *statements.of_posts(found)]
    said += [*statements.of_shift(found), Phrase(statements.REMEMBER)]
    lines += [f"  {phrase}." for phrase in said]
    return lines + [
        f"  NIOSH lifting index at {station} with these hours, for the worst of all workers: {judgement.text()}."
        for station, judgement in found.lifted.items()
    ]

"""What is said of the workers of a shift together: means over five or more, so that nobody can be told apart.

A window is a row of whole hours in which at least FEWEST workers each worked for MIN_MINUTES or more; hours with fewer
are joined with their neighbours. Windows do not overlap, nothing is summed over them, and how many workers there were
is not said, so that no number is left when others are subtracted. Every worker counts the same, however long he worked:
none can dominate. Nothing is said before a shift is closed, for two reports of one shift could be subtracted, too.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from fatigue_planner.core.text import fixed, format_label, listing, percent
from fatigue_planner.live.hindsight import Hindsight
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Block, Section, Table, Text
from fatigue_planner.output.reports.shift.data import ShiftData, sight_of, together
from fatigue_planner.study.statistics.pairing import records

FEWEST = 5
MIN_MINUTES = 10.0
MOST_ENTRIES = 12
# The measures by name, with words and how a number is written.
MEASURES = (
    ("pause_min_per_hour", "Pauses, in minutes per hour", fixed),
    ("dose_s_per_hour", "Load dose, in s per hour of work", fixed),
    ("mean_fatigue", "Fatigue", lambda value: percent(value, 0)),
)

# By worker and hour: minutes worked of which something may be known, minutes of pauses.
Times = dict[str, dict[int, tuple[float, float]]]


@dataclass(frozen=True)
class Window:
    """Whole hours, first to last, and the workers whose means are given."""

    first: int
    last: int
    members: tuple[str, ...]


def group_sections(data: ShiftData, figures: FigureFolder) -> tuple[list[str], list[Section]]:
    """What can be said of the workers together: sentences for the top, and sections."""
    if not data.record.is_closed:
        why = "the shift is not closed"
    else:
        times = times_of(data)
        if found := windows(times, 1 if data.is_rehearsal else FEWEST):
            return [], [_loads(data, times, found, figures), *_worth(data, found)]
        why = f"fewer than {FEWEST} worked long enough"
    return [
        f"Nothing is said of the workers together, because {why}. Each can have a report of his own "
        "(`fatplan live report --worker`)."
    ], []


def times_of(data: ShiftData) -> Times:
    """How long each worker worked and rested, by hour."""
    found: Times = {worker: {} for worker in data.record.workers}
    known = [part for part in data.parts if part.scenario is not None]  # of others there is no estimate
    for part in known:
        for one in part.segment.worked():
            if sight_of(one.end) not in {"off", "skipped"}:
                _add(found, one.worker, data.hour_of(one.ended_s), data.worked_s(part, one) / 60, 0.0)
        for pause in part.segment.pauses(data.planned_s(part)):
            if pause.kind != "away" and pause.worker in found:
                _add(found, pause.worker, data.hour_of(pause.ended_s), 0.0, pause.seconds / 60)
    return found


def _add(times: Times, worker: str, hour: int, worked: float, rested: float) -> None:
    before = times[worker].get(hour, (0.0, 0.0))
    times[worker][hour] = before[0] + worked, before[1] + rested


def windows(times: Times, fewest: int) -> list[Window]:
    """As many windows as there can be, each with at least so many workers, that together hold all hours; or none."""
    hours = sorted({hour for own in times.values() for hour in own})
    if not hours:
        return []
    found: list[Window] = []
    first = hours[0]
    for hour in range(hours[0], hours[-1] + 1):
        members = _members(times, first, hour)
        if len(members) >= fewest:
            found.append(Window(first, hour, members))
            first = hour + 1
    if found and first <= hours[-1]:  # what is left over joins the last one
        last = found.pop()
        found.append(Window(last.first, hours[-1], _members(times, last.first, hours[-1])))
    return found


def _members(times: Times, first: int, last: int) -> tuple[str, ...]:
    return tuple(worker for worker in times if _within(times, worker, first, last)[0] >= MIN_MINUTES)


def _within(times: Times, worker: str, first: int, last: int) -> tuple[float, float]:
    """The minutes that a worker worked and rested in a window."""
    own = [minutes for hour, minutes in times[worker].items() if first <= hour <= last]
    return sum(one[0] for one in own), sum(one[1] for one in own)


def group_table(data: ShiftData, times: Times, found: Sequence[Window]) -> pd.DataFrame:
    """By window and entry, means over the workers: dose in s per hour of work, fatigue; and pauses in min per hour.

    Only entries of which as many workers as a window needs have a value: a mean of fewer would tell of one.
    """
    fewest = 1 if data.is_rehearsal else FEWEST
    doses = {worker: data.doses_table(worker) for worker in data.record.workers}
    fatigue = {worker: data.fatigue_table(worker) for worker in data.record.workers}
    for table in fatigue.values():
        table["hour"] = [data.hour_of(at_s) for at_s in table["at_s"]]
    rows: list[dict[str, Any]] = []
    for window in found:
        where: dict[str, Any] = {
            "from": f"{data.hour_begins(window.first):%H:%M}", "to": f"{data.hour_begins(window.last + 1):%H:%M}"
        }  # fmt: skip
        spans = {worker: _within(times, worker, window.first, window.last) for worker in window.members}
        of_dose = [
            _of(doses[worker], window).groupby("entry", sort=False)["dose_s"].sum() / (spans[worker][0] / 60)
            for worker in window.members
        ]
        of_fatigue = [
            _of(fatigue[worker], window).groupby("entry", sort=False)["mean"].mean() for worker in window.members
        ]
        rested = [60 * rest / (work + rest) for work, rest in spans.values()]
        rows.append(where | {"measure": "pause_min_per_hour", "entry": None, "value": sum(rested) / len(rested)})
        for measure, own in (("dose_s_per_hour", of_dose), ("mean_fatigue", of_fatigue)):
            values = pd.concat(own, axis=1)
            means = values[values.notna().sum(axis=1) >= fewest].fillna(0.0).mean(axis=1)
            rows += [where | {"measure": measure, "entry": entry, "value": mean} for entry, mean in means.items()]
    return pd.DataFrame(rows)


def _of(table: pd.DataFrame, window: Window) -> pd.DataFrame:
    return table[table["hour"].between(window.first, window.last)]


def _loads(data: ShiftData, times: Times, found: Sequence[Window], figures: FigureFolder) -> Section:
    table = group_table(data, times, found)
    file = figures.add_table("group", table)
    spans = [f"{data.hour_begins(one.first):%H:%M}–{data.hour_begins(one.last + 1):%H:%M}" for one in found]
    who = "the simulated workers" if data.is_rehearsal else f"{FEWEST} or more workers, who all count the same"
    blocks: list[Block] = [
        Text(
            "The model's fatigue is that of single muscles over minutes. A load dose adds up how hard a muscle group "
            "had to work while that was hard enough to tire it. Hours in which too few worked are joined with others. "
            "Nobody is compared with anybody."
        )
    ]
    for measure, words, form in MEASURES:
        own = table[table["measure"] == measure].fillna({"entry": "all"})
        order = own.groupby("entry", sort=False)["value"].max().sort_values(ascending=False, kind="stable")
        cells = {(row["entry"], row["from"]): row["value"] for row in records(own)}
        rows = [
            [format_label(entry), *(form(cells.get((entry, span[:5]), 0.0)) for span in spans)]
            for entry in order[order > 0].head(MOST_ENTRIES).index
        ]
        if rows:
            caption = f"{words}: means over {who}, by local time."
            blocks.append(Table(caption, ["joint and direction", *spans], rows, file))
    return Section("The work of all", blocks)


def _worth(data: ShiftData, found: Sequence[Window]) -> list[Section]:
    """What the plan was worth: the mean of what it was worth to each of those of whom something is said."""
    members = list(dict.fromkeys(worker for window in found for worker in window.members))
    own: list[Hindsight] = [one for one in (together(data.worth(worker)) for worker in members) if one is not None]
    if len(own) < (1 if data.is_rehearsal else FEWEST):
        return []
    plans = [plan for plan in own[0].others if all(plan in one.others for one in own)]
    points = []
    for plan in plans:
        saving = sum(one.saving(plan)[0] for one in own) / len(own)
        if not math.isfinite(saving):  # to some of them the plan would have cost nothing
            continue
        word = "less" if saving >= 0 else "more"
        points.append(f"{percent(abs(saving))} {word} fatigue than {plan} would have")
    if not points:
        return []
    words = f"By the model, and on average over the workers, what the robot did cost {listing(points)}."
    return [
        Section(
            "What following the plan was worth",
            [
                Text(words),
                Text(
                    "This is an estimate by replay, not a measurement; a worker's own report says how it is made and "
                    "how uncertain it is."
                ),
            ],
        )
    ]

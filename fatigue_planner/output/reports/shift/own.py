"""What a worker reads about his own shift; nobody else's cycles are in it, and not his pseudonym."""

import math

import pandas as pd

from fatigue_planner.core.text import counted, fixed, format_label, listing, percent, percent_range
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.live.events import Alarmed
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Block, Section, Table, Text
from fatigue_planner.output.reports.shift.courses import course_picture, most_tired
from fatigue_planner.output.reports.shift.data import ShiftData, offset, stamp, together
from fatigue_planner.output.reports.shift.decisions import MAX_ROWS, decisions_section, of_all, sight_section
from fatigue_planner.output.reports.shift.loads import doses_section
from fatigue_planner.output.reports.shift.worth import worth_section, worth_words
from fatigue_planner.study.statistics.pairing import records

FORGETS = (
    "Fatigue here is that of single muscles over minutes: the model forgets it at rest, as the half-lives in the table "
    "say. It says nothing about how tired somebody is in the evening; the load doses, which add up, stand beside it."
)
KINDS = {"said": "was announced", "clock": "by the clock, between two cycles", "away": "while others worked here"}


def own_sections(data: ShiftData, worker: str, figures: FigureFolder) -> tuple[list[str], list[Section]]:
    """The sentences at the top of a worker's report, and its sections; figures and tables go to the folder."""
    cycles, fatigue, doses = data.cycles_table(worker), data.fatigue_table(worker), data.doses_table(worker)
    worth = together(data.worth(worker))
    found = [*_summary(data, worker, cycles), *worth_words(worth)]
    sections = [
        fatigue_section(data, worker, fatigue, figures),
        doses_section(doses, figures),
        pauses_section(data, worker, figures),
        decisions_section(cycles, figures),
        sight_section(cycles),
        worth_section(worth, figures),
    ]
    return found, [section for section in sections if section is not None]


def _summary(data: ShiftData, worker: str, cycles: pd.DataFrame) -> list[str]:
    mine = [one for one in data.worked if one.worker == worker]
    first, last = data.record.local(mine[0].ended_s), data.record.local(mine[-1].ended_s)
    pauses = [one for one in data.pauses if one.worker == worker and one.kind != "away"]
    found = [
        f"You worked {counted(len(mine), 'cycle')}; the first ended at {first:%H:%M}, the last at {last:%H:%M} "
        f"({offset(last)}). {counted(len(pauses), 'pause')} took {fixed(sum(one.seconds for one in pauses) / 60)} min."
    ]
    if blind := int((cycles["seen"] == "nothing").sum()):
        found.append(f"Of {counted(blind, 'cycle')} nothing was seen: there the estimate is a guess, and says so.")
    if off := int((cycles["seen"] == "off").sum()):
        found.append(
            f"In {counted(off, 'cycle')} the belief about you was switched off: a schedule decided, and nothing "
            "of what you did was kept."
        )
    return found


def fatigue_section(data: ShiftData, worker: str, table: pd.DataFrame, figures: FigureFolder) -> Section:
    """The courses, and when each muscle was most tired."""
    highest = most_tired(table, MAX_ROWS) if len(table) else table
    if not len(highest):
        return Section("Fatigue", [Text("Nothing was estimated.")])
    half_life_s = _half_lives(data)
    mean = table.groupby("entry", sort=False)["mean"].mean()
    rows = [
        [
            format_label(row["entry"]), percent(row["mean"], 0), percent_range(row["low"], row["high"], 0),
            row["time"][11:16], percent(mean[row["entry"]], 0), f"{half_life_s[row['entry']]:.0f} s",
        ]
        for row in records(highest)
    ]  # fmt: skip
    caption = (
        "The highest estimated fatigue of every muscle group that the work tires, by joint and direction, the interval "
        "that held 90 % of what was believed then, and the mean over all moments. Half-life: after so long a rest, "
        "half of it is left. What stays below 0.5 % is left out."
    )
    header = ["joint and direction", "highest", "90 % interval", "at", "mean", "half-life"]
    return Section(
        "Fatigue",
        [Text(FORGETS), course_picture(data, worker, table, figures), Table(caption, header, rows, "fatigue.csv")],
    )


def _half_lives(data: ShiftData) -> dict[str, float]:
    """By entry, how long the average worker's fatigue takes to halve at rest, in s."""
    scenario = data.parts[-1].scenario
    assert scenario is not None and scenario.model.timing is not None
    fade, _ = scenario.model.timing.rest.rates(1.0, 1.0)
    return {entry: math.log(2) / rate if rate > 0 else math.inf for entry, rate in zip(ENTRIES, fade, strict=False)}


def pauses_section(data: ShiftData, worker: str, figures: FigureFolder) -> Section:
    """The pauses that were taken, and hours without one."""
    mine = [one for one in data.pauses if one.worker == worker]
    hours = sorted({data.hour_of(one.ended_s) for one in data.worked if one.worker == worker})
    rested = {data.hour_of(one.ended_s) for one in mine}
    wanted = suggested(data, worker, figures)
    without = [f"{data.hour_begins(hour):%H:%M}" for hour in hours if hour not in rested]
    words = f"Hours in which you worked without a pause began at {listing(without)}." if without else ""
    if not mine:
        return Section("Pauses", [Text(f"None was taken. {words}".strip()), *wanted])
    table = pd.DataFrame(
        [
            {"ended": stamp(data.record.local(one.ended_s)),
             "seconds": one.seconds, "kind": one.kind}
            for one in mine
        ]
    )  # fmt: skip
    file = figures.add_table("pauses", table)
    rows = [[row["ended"][11:16], f"{row['seconds'] / 60:.1f} min", KINDS[row["kind"]]] for row in records(table)]
    caption = f"Pauses, by when each was over{of_all(rows)}. One between two cycles counts from 1 s on."
    blocks: list[Block] = [Text(words)] if words else []
    blocks.append(Table(caption, ["over at", "length", "how it is known"], rows[:MAX_ROWS], file))
    return Section("Pauses", [*blocks, *wanted])


def suggested(data: ShiftData, worker: str, figures: FigureFolder) -> list[Block]:
    """The pauses that alarms asked for."""
    alarms = [
        (stamp(data.record.local(aside.at_s)), aside.event)
        for part in data.parts
        for aside in part.segment.asides
        if isinstance(aside.event, Alarmed) and aside.worker == worker
    ]
    if not alarms:
        return [Text("No alarm asked for a pause.")]
    file = figures.add_table("alarms", pd.DataFrame([{"time": time} | alarm.plain() for time, alarm in alarms]))
    rows = [
        [
            time[11:16], format_label(alarm.entry), percent(alarm.probability, 0),
            "none is long enough" if alarm.pause_s is None else f"{alarm.pause_s / 60:.1f} min",
        ]
        for time, alarm in alarms
    ]  # fmt: skip
    caption = (
        f"Pauses that alarms asked for{of_all(rows)}: how likely it was that the joint was above the limit that the "
        "employer set, and the pause that was long enough with 90 % probability."
    )
    return [Table(caption, ["at", "joint and direction", "probability", "pause"], rows[:MAX_ROWS], file)]

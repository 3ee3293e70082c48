"""How the program ran: answers, fallbacks, restarts, the clock; nothing in it is about a person."""

from collections import Counter

import numpy as np

from fatigue_planner.core.text import fixed, listing, percent, times
from fatigue_planner.live.events import CameLate, ClockSet, Decided, Executed, Observed
from fatigue_planner.output.reports.page import Block, Points, Section, Table, Text
from fatigue_planner.output.reports.shift.data import ShiftData

# What happened to the program, in words, by kinds of events.
HAPPENED = {
    "resumed": "The program was started again {}.",
    "recovered": "The journal was damaged, and copied up to there, {}.",
    "config": "Policy, deadline or limit were changed {}.",
    "slept": "The machine slept {}.",
    "search_failed": "The search that improves decisions gave no answer {}; the policy decided.",
    "contradicted": "Something else was said of a cycle than before {}; the first stood.",
    "silent": "The robot did not answer {}.",
}


def running_section(data: ShiftData, worker: str | None, exactly: bool) -> Section:
    """Answers and their times as fractions, and what happened to the program.

    worker: whose cycles; None: all. exactly: otherwise fractions are whole per cent, which do not tell of how many.
    """
    off = {id(one.decided) for one in data.worked if isinstance(one.end, Observed) and one.end.off}
    if worker is None:
        decided = [one for part in data.parts for one in part.segment.decided]
    else:
        decided = [one.decided for one in data.worked if one.worker == worker and one.decided is not None]
    blocks: list[Block] = []
    if decided:
        times_ms = 1000 * np.array([one.duration_s for one in decided])
        deadline_s = data.parts[-1].segment.opened.deadline_s
        rows = [
            [f"later than the deadline of {1000 * deadline_s:g} ms", _share([one.late for one in decided], exactly)],
            *_came_late(data, worker, deadline_s),
            ["read from what had been prepared", _share([one.prepared for one in decided], exactly)],
            ["decided by a fallback", _share([_fell_back(one, off) for one in decided], exactly)],
            ["time of an answer: median", f"{np.median(times_ms):.2f} ms"],
            ["longest of 100, of 1,000, of all", " / ".join(
                f"{value:.2f}" for value in (*np.quantile(times_ms, [0.99, 0.999]), times_ms.max())) + " ms"],
        ]  # fmt: skip
        caption = "Answers to the robot. Where the belief about a worker was off, the schedule is no fallback."
        blocks.append(Table(caption, ["answers", "share or time"], rows))
        if reasons := _reasons(decided, off):
            blocks.append(Points([f"A fallback decided because: {listing(reasons)}."]))
    else:
        blocks.append(Text("Nothing was decided."))
    blocks.append(Points(_events(data)))
    return Section("How the program ran", blocks)


def _came_late(data: ShiftData, worker: str | None, deadline_s: float) -> list[list[str]]:
    """Answers that came late to the client, of the whole shift; nobody says of them whose cycle it was."""
    waited_s = [
        aside.event.seconds for part in data.parts for aside in part.segment.asides if isinstance(aside.event, CameLate)
    ]
    if worker is not None or not waited_s:
        return []
    what = f"came to the client later than {1000 * deadline_s:g} ms, as it says; longest"
    return [[what, f"{len(waited_s)}; {1000 * max(waited_s):.0f} ms"]]


def _fell_back(one: Decided, off: set[int]) -> bool:
    return one.fallback != "none" and id(one) not in off


def _share(are: list[bool], exactly: bool) -> str:
    fraction = sum(are) / len(are)
    if fraction in {0, 1}:
        return "all" if fraction else "none"
    return percent(fraction) if exactly else "less than 1 %" if fraction < 0.01 else percent(fraction, 0)


def _reasons(decided: list[Decided], off: set[int]) -> list[str]:
    found = Counter(one.reason for one in decided if _fell_back(one, off))
    return [f"`{reason}`" for reason, _ in found.most_common(5)]


def _events(data: ShiftData) -> list[str]:
    """What happened, in sentences."""
    record = data.record
    asides = [aside for part in data.parts for aside in part.segment.asides]
    kinds: Counter[str] = Counter(aside.event.kind for aside in asides)
    kinds["silent"] = sum(isinstance(aside.event, Executed) and aside.event.action is None for aside in asides)
    found = [text.format(times(kinds[kind])) for kind, text in HAPPENED.items() if kinds[kind]]
    for aside in asides:
        if isinstance(aside.event, ClockSet):
            by_s = aside.event.difference_s
            found.append(
                f"The clock was set {'forward' if by_s > 0 else 'back'} by {fixed(abs(by_s))} s at "
                f"{record.local(aside.at_s):%H:%M:%S}; durations did not change."
            )
    if not kinds["resumed"]:
        found.insert(0, "The program ran without a restart.")
    if len(data.parts) > 1:
        found.append(f"The shift has {len(data.parts)} parts, each begun anew with its own settings.")
    if not record.is_closed:
        pending = data.parts[-1].segment.decided
        ended = {one.cycle for one in data.parts[-1].segment.worked()}
        within = " in the middle of a cycle" if pending and pending[-1].cycle not in ended else ""
        found.append(f"The journal was not closed: it stops{within} at {record.local(record.lasted_s):%H:%M:%S}.")
    return found

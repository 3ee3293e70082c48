"""What is intact of a damaged journal becomes a new one, with which a shift goes on; who switched off stays off."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from urllib.parse import quote

from fatigue_planner.core.errors import CycleError, DamagedJournalError, OutputFolderError
from fatigue_planner.core.files import publish
from fatigue_planner.live.events import ANY_EVENT, Advice, Event, Observed, Opened, Recovered, Skipped, WorkerChanged
from fatigue_planner.live.journal_file import (
    BEGINNING,
    Stored,
    append,
    body_of,
    connect,
    create,
    intact,
    last_cycle,
    pseudonyms,
)
from fatigue_planner.live.opening import off_after, since_opened


def recover(path: Path, into: Path, from_cycle: int | None = None) -> list[Stored]:
    """Copy what is intact of a damaged journal, from its beginning, to a new one, and note that; the events copied.

    from_cycle: the cycle to go on with, of the shift that was opened last; by default the one after the last intact.
    Workers who switched the belief about them off in what is left out, damaged or not, are switched off after it.

    Raises OutputFolderError if the new one is there or cannot be written, or the old one is no journal; CycleError if
    it is not intact so far.
    """
    whole, _ = intact(path)
    if into.exists():
        raise OutputFolderError(f"{into}: is there already; choose another name.")
    last = last_cycle(whole)
    cycle = last + 1 if from_cycle is None else from_cycle
    if not 1 <= cycle <= last + 1:
        raise CycleError(f"cycle {cycle}: cannot be gone on with; the journal is intact up to cycle {last}.")
    events = whole[: _before_the_end_of(whole, cycle)] if cycle <= last else whole
    workers: dict[str, str] = {}
    with suppress(DamagedJournalError):
        workers = pseudonyms(path) if events else {}

    def write(temporary: Path) -> None:
        create(temporary)
        with closing(connect(temporary)) as connection:
            rows = [(one.number, one.seconds, one.utc, body_of(one.event)) for one in events]
            if rows:
                notes = [Recovered(intact=len(whole), kept=len(rows), cycle=cycle), *_switches(path, whole, events)]
                at = rows[-1][1:3]
                rows += [(len(rows) + number, *at, body_of(note)) for number, note in enumerate(notes)]
            append(connection, BEGINNING, rows)
            connection.executemany("INSERT INTO worker VALUES (?, ?)", workers.items())
            connection.execute("PRAGMA journal_mode = DELETE")

    publish(into, write)
    into.chmod(0o600)
    return events


def _switches(path: Path, whole: list[Stored], kept: list[Stored]) -> Iterator[Event]:
    """The inputs that switch off, after what was kept, who switched off in what was left out; then all is as it was."""
    left_out = [*(one.event for one in whole[len(kept) :]), *_readable(path, len(whole))]
    before = since_opened(kept)
    here = _worker(before)
    lost = _off_in(left_out, here, {""} | {one.event.worker for one in before if isinstance(one.event, WorkerChanged)})
    lost -= set(off_after(before))
    if here in lost:
        yield Advice(on=False)
    others = sorted(lost - {here})
    for worker in others:
        yield WorkerChanged(worker=worker)
        yield Advice(on=False)
    if others:
        yield WorkerChanged(worker=here, away_s=0.0)


def _off_in(events: list[Event | None], here: str | None, known: set[str]) -> set[str]:
    """The workers who are off after events, some of which may not be known; before them one was here."""
    off: set[str] = set()
    for event in events:
        match event:
            case None:  # it may have been another worker's coming
                here = None
            case Opened(off=before):
                off.update(before)
                here = ""
            case WorkerChanged(worker=worker):
                here = worker
                known = known | {worker}
            case Advice(on=False):
                off.update(known if here is None else {here})
            case Advice(on=True) if here is not None:
                off.discard(here)
    return off


def _readable(path: Path, first: int) -> Iterator[Event | None]:
    """The events from the first that is damaged, as they read; None in the place of what cannot be read."""
    yield None
    with (
        suppress(sqlite3.Error),
        closing(sqlite3.connect(f"file:{quote(str(path.resolve()))}?mode=ro", uri=True)) as connection,
    ):
        rows = connection.execute("SELECT number, body FROM event WHERE number >= ? ORDER BY number", (first,))
        for number, body in rows:
            if number != first:
                yield None
            first = number + 1
            try:
                event = ANY_EVENT.validate_json(body)
            except (ValueError, TypeError):
                yield None
            else:
                if event != Advice(on=True):  # that must be sure
                    yield event


def _worker(events: list[Stored]) -> str:
    """Who was here at the end."""
    here = [one.event.worker for one in events if isinstance(one.event, WorkerChanged)]
    return here[-1] if here else ""


def _before_the_end_of(events: list[Stored], cycle: int) -> int:
    """How many events there are before the end of a cycle of the shift that was opened last."""
    number = len(events)
    while number > 0 and not isinstance(events[number - 1].event, Opened):
        number -= 1
    while number < len(events):
        event = events[number].event
        if isinstance(event, Observed | Skipped) and event.cycle == cycle:
            break
        number += 1
    return number

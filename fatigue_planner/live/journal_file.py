"""The journal's file: an SQLite database of numbered events, chained by SHA-256, that is only ever appended to.

Row n carries the digest of row n - 1's digest and of what row n says, so a changed, removed or inserted row is found.
What joins a worker's random number to a pseudonym is a table of its own, which is not in the chain and can be erased.
"""

import fcntl
import hashlib
import os
import re
import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from urllib.parse import quote

from fatigue_planner.core.errors import (
    DamagedJournalError,
    JournalInUseError,
    OtherVersionError,
    OutputFolderError,
)
from fatigue_planner.core.files import canonical_json
from fatigue_planner.live.events import ANY_EVENT, FORMAT, Event, Observed, Opened, Skipped

SCHEMA = """
CREATE TABLE IF NOT EXISTS event (
  number INTEGER PRIMARY KEY, kind TEXT NOT NULL, seconds REAL NOT NULL, utc TEXT NOT NULL, body TEXT NOT NULL,
  digest TEXT NOT NULL
) STRICT;
CREATE TABLE IF NOT EXISTS worker (random TEXT PRIMARY KEY, pseudonym TEXT NOT NULL UNIQUE) STRICT;
"""
# In "fatp", so that `file` and SQLite tell a journal from other databases.
APPLICATION_ID = 0x66617470
BEGINNING = "fatplan journal"  # what the first row is chained to
# A program that ends may take so long; the process of one that was killed writes what had been handed over first.
LOCK_WAIT_S, ORPHAN_WAIT_S = 5.0, 60.0


@dataclass(frozen=True)
class Stored:
    """An event of a journal, its number from 0, the clock's seconds and the time of day when it happened."""

    number: int
    seconds: float
    utc: str
    event: Event


def chained(previous: str, number: int, seconds: float, utc: str, body: str) -> str:
    """The digest of a row after the row with the digest `previous`."""
    return hashlib.sha256(canonical_json([previous, number, seconds, utc, body]).encode()).hexdigest()


def body_of(event: Event) -> str:
    """The one text of an event."""
    return canonical_json(event.plain())


def connect(path: Path) -> sqlite3.Connection:
    """A connection that writes durably: what a commit has returned from is on the disk, unless that lies."""
    connection = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA synchronous = FULL")
    connection.execute("PRAGMA secure_delete = ON")
    return connection


def create(path: Path) -> None:
    """Make an empty journal that only its owner can read; it is there whole or not at all. Raises OutputFolderError."""
    begun = path.with_name(f"{path.name}.begun")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for left in ("", "-wal", "-shm"):  # by a program that was killed here
            begun.with_name(f"{begun.name}{left}").unlink(missing_ok=True)
        os.close(os.open(begun, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        with closing(connect(begun)) as connection:
            connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            connection.executescript(SCHEMA)
        begun.replace(path)
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
    except (OSError, sqlite3.Error) as error:
        raise OutputFolderError(f"{path}: a journal cannot be written there ({error}).") from error


def read_journal(path: Path) -> list[Stored]:
    """All events, in order.

    Raises DamagedJournalError if they are not what was written, with what is still intact; OtherVersionError for a
    journal of another version; OutputFolderError if there is none.
    """
    events, fault = intact(path)
    if fault:
        raise DamagedJournalError(fault)
    return events


def append(connection: sqlite3.Connection, previous: str, rows: list[tuple[int, float, str, str]]) -> str:
    """Append rows (number, seconds, utc, body) in one commit; the digest of the last."""
    connection.execute("BEGIN IMMEDIATE")
    for number, seconds, utc, body in rows:
        previous = chained(previous, number, seconds, utc, body)
        kind = ANY_EVENT.validate_json(body).kind
        connection.execute("INSERT INTO event VALUES (?, ?, ?, ?, ?, ?)", (number, kind, seconds, utc, body, previous))
    connection.execute("COMMIT")
    return previous


def last_row(connection: sqlite3.Connection) -> tuple[int, str]:
    """Number and digest of the last row; -1 where there is none."""
    row = connection.execute("SELECT number, digest FROM event ORDER BY number DESC LIMIT 1").fetchone()
    return (-1, BEGINNING) if row is None else (int(row[0]), str(row[1]))


def last_seconds(path: Path) -> float:
    """What the clock showed at the last event; 0 where there is no journal, or none in it."""
    if not path.exists():
        return 0.0
    return max((one.seconds for one in read_journal(path)), default=0.0)


def pseudonyms(path: Path) -> dict[str, str]:
    """By random number, the pseudonyms of the workers that have not been erased.

    Raises DamagedJournalError if their table cannot be read.
    """
    try:
        with closing(sqlite3.connect(path)) as connection:
            return dict(connection.execute("SELECT random, pseudonym FROM worker").fetchall())
    except sqlite3.Error as error:
        raise DamagedJournalError(
            f"{path}: the table of pseudonyms is damaged ({error}). `fatplan live recover` makes a journal of its "
            "events, in which the workers have random numbers only."
        ) from error


def erase(path: Path, pseudonym: str) -> bool:
    """Erase what joins a worker's events to a pseudonym; whether there was such a worker.

    No byte of the pseudonym is left in the journal's files; whether its events are intact does not matter. Raises
    JournalInUseError while a session writes it, DamagedJournalError if bytes may be left, OutputFolderError if there is
    no such journal.
    """
    with suppress(OtherVersionError):  # its table of pseudonyms is the same
        intact(path)
    with lock(path):
        try:
            return _erased(path, pseudonym)
        except sqlite3.Error as error:
            raise DamagedJournalError(
                f"{path}: the file is damaged where it holds pseudonyms ({error}), which cannot be erased one by one. "
                f"`fatplan live recover {path} NEW` makes a journal of what is intact; then remove this file."
            ) from error


def _erased(path: Path, pseudonym: str) -> bool:
    """Whether there was such a worker, who is erased now. Raises sqlite3.Error if bytes may be left."""
    with closing(connect(path)) as connection:
        erased = connection.execute("DELETE FROM worker WHERE pseudonym = ?", (pseudonym,)).rowcount > 0
        try:
            connection.execute("VACUUM")
        except sqlite3.DatabaseError:  # pages of events are damaged; what was deleted has been overwritten
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            if pseudonym.encode() in path.read_bytes():
                raise
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    return erased


@contextmanager
def lock(path: Path) -> Iterator[int]:
    """Be the only one who writes a journal; the descriptor of its lock, which a child process may inherit.

    Raises JournalInUseError, naming who has it and since when.
    """
    descriptor = os.open(path.with_name(f"{path.name}.lock"), os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o600)
    try:
        began = time.monotonic()
        while True:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                holder = os.pread(descriptor, 200, 0).decode("ascii", "replace")
                if time.monotonic() > began + (LOCK_WAIT_S if _lives(holder) else ORPHAN_WAIT_S):
                    raise JournalInUseError(f"{path}: is being written by {holder or 'another program'}.") from None
                time.sleep(0.05)
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"process {os.getpid()} since {datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC".encode(), 0)
        yield descriptor
    finally:
        os.close(descriptor)


def _lives(holder: str) -> bool:
    """Whether the program that a lock names is still there."""
    number = re.match(r"process (\d+) ", holder)
    return number is None or Path(f"/proc/{number[1]}").exists() or not Path("/proc").is_dir()


def intact(path: Path) -> tuple[list[Stored], str]:
    """The events from the beginning that are what was written, and what is wrong after them."""
    if not path.is_file():
        raise OutputFolderError(f"{path}: there is no such journal.")
    events: list[Stored] = []
    previous = BEGINNING
    try:
        with closing(sqlite3.connect(f"file:{quote(str(path.resolve()))}?mode=ro", uri=True)) as connection:
            if connection.execute("PRAGMA application_id").fetchone()[0] != APPLICATION_ID:
                raise OutputFolderError(f"{path}: is no journal of fatplan.")
            for number, kind, seconds, utc, body, digest in connection.execute("SELECT * FROM event ORDER BY number"):
                event = ANY_EVENT.validate_json(body)
                if isinstance(event, Opened) and event.format != FORMAT:
                    raise OtherVersionError(
                        f"{path}: was written in format {event.format}, this version reads {FORMAT}; "
                        f"go on with fatplan {event.versions.get('fatplan', '?')}."
                    )
                right = chained(previous, len(events), seconds, utc, body)
                if number != len(events) or digest != right or kind != event.kind:
                    return events, _damage(path, events)
                previous = digest
                events.append(Stored(number, seconds, utc, event))
    except (sqlite3.Error, ValueError, TypeError):  # what pydantic and the decoder find are ValueErrors
        return events, _damage(path, events)
    return events, ""


def last_cycle(events: list[Stored]) -> int:
    """The last cycle of the shift that was opened last."""
    last = 0
    for one in events:
        if isinstance(one.event, Opened):
            last = 0
        elif isinstance(one.event, Observed | Skipped):
            last = max(last, one.event.cycle)
    return last


def _damage(path: Path, events: list[Stored]) -> str:
    return (
        f"{path}: event {len(events)} is not what was written; the file was altered or damaged. Intact are "
        f"{len(events)} events, up to cycle {last_cycle(events)}. Nothing was changed. "
        f"`fatplan live recover {path} NEW` copies them to a new journal, with which to go on; "
        "--from CYCLE goes on with an earlier cycle."
    )

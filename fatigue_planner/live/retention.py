"""How long journals are kept: which of a folder are too old, and their removal with all that belongs to them.

The age counts from a journal's last event, by the time of day that it was given. A journal that is damaged is removed,
too; one that is being written is not. Reports are copies in other folders, which this does not know of.
"""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from urllib.parse import quote

from fatigue_planner.core.errors import JournalInUseError, OutputFolderError
from fatigue_planner.live.journal_file import APPLICATION_ID, lock

# What lies beside a journal and is named after it.
BESIDE = ("-wal", "-shm", ".view-token", ".act-token", ".lock")
# Times before fatplan are those of rehearsals, or of clocks that were not set.
FIRST = datetime(2020, 1, 1, tzinfo=UTC)
MAGIC, ID_AT = b"SQLite format 3\0", 68  # of every SQLite file; where the application's number stands


@dataclass(frozen=True)
class OldJournal:
    """A journal that is older than it should become. last: the time of its last event; files: all that are its."""

    path: Path
    last: datetime
    files: tuple[Path, ...]


def too_old(folder: Path, keep_days: float, now: datetime) -> list[OldJournal]:
    """The journals of a folder whose last event is more than so many days ago, the oldest first.

    Raises OutputFolderError if there is no such folder.
    """
    if not folder.is_dir():
        raise OutputFolderError(f"{folder}: there is no such folder.")
    found = []
    for path in sorted(folder.iterdir()):
        if is_journal(path) and (last := _last_event(path)) < now - timedelta(days=keep_days):
            beside = [path.with_name(path.name + ending) for ending in BESIDE]
            found.append(OldJournal(path, last, (path, *(file for file in beside if file.exists()))))
    return sorted(found, key=lambda one: one.last)


def remove_old(journals: list[OldJournal]) -> Iterator[tuple[OldJournal, str]]:
    """Remove journals one by one; each with why it is still there, "" for one that is gone."""
    for one in journals:
        try:
            with lock(one.path):
                for ending in ("", *BESIDE):
                    one.path.with_name(one.path.name + ending).unlink(missing_ok=True)
        except (JournalInUseError, OSError) as error:
            yield one, str(error)
        else:
            yield one, ""


def is_journal(path: Path) -> bool:
    """Whether a file is a journal of fatplan, by its first bytes."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(ID_AT + 4)
    return head.startswith(MAGIC) and head[ID_AT:] == APPLICATION_ID.to_bytes(4)


def _last_event(path: Path) -> datetime:
    """When the last event of a journal was; where that cannot be read or known, when the file was changed last."""
    try:
        # a reader leaves files behind, unless nothing is in them that it has to read
        how = "mode=ro" if path.with_name(f"{path.name}-wal").exists() else "immutable=1"
        with closing(sqlite3.connect(f"file:{quote(str(path.resolve()))}?{how}", uri=True)) as connection:
            row = connection.execute("SELECT utc FROM event ORDER BY number DESC LIMIT 1").fetchone()
        if row is not None and (last := datetime.fromisoformat(row[0])) > FIRST:
            return last
    except (sqlite3.Error, ValueError, TypeError):
        pass
    return datetime.fromtimestamp(path.stat().st_mtime, UTC)

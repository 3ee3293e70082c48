"""Old journals are listed and, if that is asked for, removed with all that is theirs; nothing else is touched."""

import json
import sqlite3
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from commands import fatplan
from journals import write_journal

from fatigue_planner.live import journal_file
from fatigue_planner.live.events import Noted
from fatigue_planner.live.journal_file import Stored, connect, lock
from fatigue_planner.live.retention import remove_old, too_old

NOW = datetime.now(UTC)


def journal(path: Path, days_ago: float) -> Path:
    """A journal whose last event was so many days ago."""
    utc = (NOW - timedelta(days=days_ago)).isoformat()
    write_journal(path, [Stored(0, 0.0, utc, Noted(text="done"))], {"0": "w-7f3a"})
    with closing(connect(path)) as connection:  # as a session leaves it
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    journal(tmp_path / "old.fatplan", 91)
    journal(tmp_path / "older", 200)
    journal(tmp_path / "new.fatplan", 89)
    for name in ("old.fatplan.act-token", "old.fatplan.lock", "notes.fatplan", "old.fatplan.txt"):
        (tmp_path / name).write_text("x")
    with closing(sqlite3.connect(tmp_path / "other.db")) as connection:
        connection.execute("CREATE TABLE event (number, utc)")
        connection.commit()
    return tmp_path


def test_the_oldest_first_by_their_last_event(folder: Path) -> None:
    """Not by the file's age, and no other file, whatever it is called."""
    found = too_old(folder, 90, NOW)
    assert [one.path.name for one in found] == ["older", "old.fatplan"]
    assert {file.name for file in found[1].files} == {"old.fatplan", "old.fatplan.act-token", "old.fatplan.lock"}
    assert too_old(folder, 300, NOW) == []


def test_listed_first_and_removed_if_asked(folder: Path) -> None:
    before = {path.name for path in folder.iterdir()}
    listed = fatplan("live", "expire", folder, "--keep-days", 90)
    assert listed.returncode == 0 and listed.stdout.count("would be removed with --remove") == 2
    assert {path.name for path in folder.iterdir()} == before
    done = fatplan("live", "expire", folder, "--keep-days", 90, "--remove", "--json")
    assert done.returncode == 0, done.stderr
    assert [one["removed"] for one in json.loads(done.stdout)["journals"]] == [True, True]
    gone = {"older", "old.fatplan", "old.fatplan.act-token", "old.fatplan.lock"}
    assert {path.name for path in folder.iterdir()} == before - gone
    again = fatplan("live", "expire", folder, "--keep-days", 90, "--remove")
    assert again.stdout == f"{folder}: no journal is older than 90 days.\n"
    assert fatplan("live", "expire", folder / "nowhere", "--keep-days", 90).returncode == 2


def test_one_that_is_written_stays(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal_file, "LOCK_WAIT_S", 0.0)
    with lock(folder / "old.fatplan"):
        done = fatplan("live", "expire", folder, "--keep-days", 90, "--remove")
    assert done.returncode == 3 and "is being written by process" in done.stdout
    assert (folder / "old.fatplan").exists() and not (folder / "older").exists()


def test_a_damaged_one_goes_by_the_age_of_its_file(folder: Path) -> None:
    damaged = folder / "old.fatplan"
    content = damaged.read_bytes()
    damaged.write_bytes(content[:100] + b"\0" * (len(content) - 100))
    assert [one.path.name for one in too_old(folder, 90, NOW)] == ["older"]
    found = too_old(folder, 90, NOW + timedelta(days=91))
    assert "old.fatplan" in {one.path.name for one in found}
    assert [why for _, why in remove_old(found)] == [""] * 3 and not damaged.exists()

"""The journal: what is durable stays, what was altered is found, who writes is alone, who is erased is gone."""

import os
import resource
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from fatigue_planner.core.errors import DamagedJournalError, JournalInUseError, OtherVersionError, OutputFolderError
from fatigue_planner.live import journal_file
from fatigue_planner.live.events import (
    FORMAT,
    Advice,
    Noted,
    Observed,
    Opened,
    Recovered,
    Rested,
    WorkerChanged,
)
from fatigue_planner.live.journal import Journal
from fatigue_planner.live.journal_file import connect, erase, pseudonyms, read_journal
from fatigue_planner.live.recovery import recover

UTC = "2026-11-28T12:00:00+00:00"
PSEUDONYM = "w-7f3a-blue-lathe"


def notes(count: int) -> list[Noted]:
    return [Noted(text=f"{number} " + "x" * 300) for number in range(count)]


def write(path: Path, count: int) -> list[Noted]:
    said = notes(count)
    with Journal(path) as journal:
        for number, one in enumerate(said):
            journal.append(one, float(number), UTC)
    return said


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "shift.fatplan"


def test_what_was_appended_is_read(path: Path) -> None:
    said = write(path, 40)
    stored = read_journal(path)
    assert [one.event for one in stored] == said
    assert [(one.number, one.seconds) for one in stored] == [(n, float(n)) for n in range(40)]
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_journal_that_was_only_begun_is_begun_anew(path: Path) -> None:
    """A program killed while it made one leaves no half of it in its place."""
    begun = path.with_name(f"{path.name}.begun")
    begun.write_bytes(b"half a database")
    said = write(path, 2)
    assert [one.event for one in read_journal(path)] == said
    assert not begun.exists()


def test_a_journal_goes_on(path: Path) -> None:
    said = write(path, 3)
    with Journal(path) as journal:
        assert [one.event for one in journal.events] == said
        assert journal.durable_up_to == 2
        number = journal.append(Rested(seconds=0.1 + 0.2), 9.5, UTC)
        assert journal.wait(number, 30)
        assert journal.durable_up_to == number == 3
    assert read_journal(path)[-1].event == Rested(seconds=0.1 + 0.2)


def test_only_one_writes(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal_file, "LOCK_WAIT_S", 0.1)
    with Journal(path):
        with pytest.raises(JournalInUseError, match=f"process {os.getpid()} since 20"):
            Journal(path)
        with pytest.raises(JournalInUseError):
            erase(path, PSEUDONYM)
    write(path, 1)


def test_the_writing_process_is_started_again(path: Path) -> None:
    said = notes(3)
    with Journal(path) as journal:
        for number, one in enumerate(said):
            journal.wait(journal.append(one, float(number), UTC), 30)
            os.kill(journal._process.pid, signal.SIGKILL)
            journal._process.wait()
    assert [one.event for one in read_journal(path)] == said


def test_a_disk_that_is_full_is_said_and_nothing_is_tried_again(path: Path) -> None:
    journal = Journal(path)
    first = journal.append(Noted(text="before"), 0.0, UTC)
    assert journal.wait(first, 30)
    resource.prlimit(journal._process.pid, resource.RLIMIT_FSIZE, (4096, 4096))
    for number in range(1, 20):
        journal.append(Noted(text="x" * 400), float(number), UTC)
    assert not journal.wait(19, 30)
    assert journal.fault
    with pytest.raises(OutputFolderError, match=r"19 events could not be recorded.*Intact are those up to number 0"):
        journal.close()
    assert [one.event for one in read_journal(path)] == [Noted(text="before")]


def test_every_alteration_is_found(path: Path) -> None:
    said = write(path, 5)
    changes = [
        "UPDATE event SET body = replace(body, '2 xxx', '2 xxy') WHERE number = 2",
        "UPDATE event SET seconds = 2.5 WHERE number = 2",
        "UPDATE event SET utc = 'now' WHERE number = 2",
        "UPDATE event SET kind = 'rested' WHERE number = 2",
        "UPDATE event SET body = '{}' WHERE number = 2",
        "DELETE FROM event WHERE number = 2",
    ]
    whole = path.read_bytes()
    for change in changes:
        path.write_bytes(whole)
        with closing(sqlite3.connect(path, isolation_level=None)) as connection:
            connection.execute(change)
        with pytest.raises(DamagedJournalError, match=r"event 2 is not what was written.*Intact are 2 events") as found:
            read_journal(path)
        assert found.value.exit_code == 4
        into = path.with_name("recovered.fatplan")
        into.unlink(missing_ok=True)
        assert [one.event for one in recover(path, into)] == said[:2]
        assert [one.event for one in read_journal(into)] == [*said[:2], Recovered(intact=2, kept=2, cycle=1)]
    write(into, 1)  # it can be gone on with


@pytest.mark.slow
def test_a_flipped_byte_is_found_or_means_nothing(path: Path) -> None:
    said = write(path, 20)
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    for place in rng.choice(len(whole), 1500, replace=False):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ (1 << rng.integers(8))]) + whole[place + 1 :])
        try:
            assert [one.event for one in read_journal(path)] == said
            assert whole[place] != ord("x")  # a byte of what was said
        except (DamagedJournalError, OutputFolderError, OtherVersionError):
            pass


def test_the_log_cut_at_any_byte_leaves_a_prefix(path: Path, tmp_path: Path) -> None:
    cut_everywhere(path, tmp_path, step=997)


@pytest.mark.slow
def test_the_log_cut_at_every_byte_leaves_a_prefix(path: Path, tmp_path: Path) -> None:
    cut_everywhere(path, tmp_path, step=13)


def cut_everywhere(path: Path, tmp_path: Path, step: int) -> None:
    """Cut the write-ahead log of a killed program at every `step`-th byte of its last 64 kB, and at its end."""
    said = notes(12)
    with closing(connect(path)) as connection:
        connection.execute("PRAGMA wal_autocheckpoint = 0")
        connection.execute(f"PRAGMA application_id = {journal_file.APPLICATION_ID}")
        connection.executescript(journal_file.SCHEMA)
        digest = journal_file.BEGINNING
        for number, one in enumerate(said):
            digest = journal_file.append(connection, digest, [(number, 0.0, UTC, journal_file.body_of(one))])
        whole, log = path.read_bytes(), path.with_name(f"{path.name}-wal").read_bytes()
    kept = []
    for length in [*range(max(0, len(log) - 65536), len(log), step), len(log)]:
        copy = tmp_path / "cut.fatplan"
        for suffix in ("-wal", "-shm"):
            copy.with_name(copy.name + suffix).unlink(missing_ok=True)
        copy.write_bytes(whole)
        copy.with_name("cut.fatplan-wal").write_bytes(log[:length])
        try:
            events = [one.event for one in read_journal(copy)]
        except OutputFolderError:  # cut before the file was a journal at all
            events = []
        assert events == said[: len(events)]
        kept.append(len(events))
    assert kept == sorted(kept)
    assert kept[-1] == len(said)


KILLED = """
import sys
from pathlib import Path
from fatigue_planner.live.events import Noted
from fatigue_planner.live.journal import Journal
journal = Journal(Path(sys.argv[1]))
while True:
    number = journal.append(Noted(text="x" * 300), 0.0, "utc")
    journal.wait(number, 30)
    print(journal.durable_up_to, flush=True)
"""


@pytest.mark.slow
def test_what_was_acknowledged_survives_a_kill(path: Path) -> None:
    """20 kills at random moments."""
    rng = np.random.default_rng(3)
    acknowledged = -1
    for _ in range(20):
        with subprocess.Popen([sys.executable, "-c", KILLED, path], stdout=subprocess.PIPE, text=True) as running:
            assert running.stdout is not None
            said = running.stdout.readline()
            time.sleep(rng.uniform(0, 0.1))
            running.kill()
            said += running.stdout.read()
        acknowledged = max(map(int, said.rpartition("\n")[0].split()))
        with Journal(path) as journal:  # waits for the process that still writes what was handed over
            assert len(journal.events) > acknowledged
    assert acknowledged > 100


def test_an_erased_worker_leaves_no_byte(path: Path) -> None:
    with Journal(path) as journal:
        journal.join("1f2e", PSEUDONYM)
        journal.join("77aa", "w-other")
        journal.append(Noted(text="after"), 0.0, UTC)
    assert pseudonyms(path) == {"1f2e": PSEUDONYM, "77aa": "w-other"}
    assert any(PSEUDONYM.encode() in file.read_bytes() for file in path.parent.iterdir())
    assert erase(path, PSEUDONYM)
    assert not erase(path, PSEUDONYM)
    assert pseudonyms(path) == {"77aa": "w-other"}
    assert not any(PSEUDONYM.encode() in file.read_bytes() for file in path.parent.iterdir())
    assert [one.event for one in read_journal(path)] == [Noted(text="after")]  # the chain still verifies


def test_a_worker_is_erased_from_a_damaged_journal(path: Path) -> None:
    """Whether an event was altered or a whole page is lost; what is left of the journal is as it was."""
    with Journal(path) as journal:
        journal.join("1f2e", PSEUDONYM)
        for number, one in enumerate(notes(200)):
            journal.append(one, float(number), UTC)
    whole = path.read_bytes()
    altered = whole.replace(b"150 xxx", b"150 xxy")
    page = 4096 * (len(whole) // 4096 // 2)
    torn = whole[:page] + bytes(4096) + whole[page + 4096 :]
    for damaged in (altered, torn):
        path.write_bytes(damaged)
        with pytest.raises(DamagedJournalError) as before:
            read_journal(path)
        assert erase(path, PSEUDONYM)
        assert pseudonyms(path) == {}
        assert not any(PSEUDONYM.encode() in file.read_bytes() for file in path.parent.iterdir())
        with pytest.raises(DamagedJournalError) as after:
            read_journal(path)
        assert str(after.value) == str(before.value)
    path.write_bytes(whole.replace(b"CREATE TABLE worker", b"CREATE TABLE w0rker"))
    with pytest.raises(DamagedJournalError, match="cannot be erased one by one"):
        erase(path, PSEUDONYM)


def test_who_switched_off_stays_off_in_what_is_recovered(path: Path) -> None:
    """Also where that was said after what was kept, or after the damage; nobody is switched on by what is damaged."""
    said = [
        opening("5e55"), Observed(cycle=1, executed="a"), WorkerChanged(worker="1"), Observed(cycle=2, executed="a"),
        Advice(on=False), WorkerChanged(worker="2"), Observed(cycle=3, executed="a"), Noted(text="altered"),
        WorkerChanged(worker="3"), Advice(on=False), WorkerChanged(worker="1"), Advice(on=True),
    ]  # fmt: skip
    with Journal(path) as journal:
        for number, one in enumerate(said):
            journal.append(one, float(number), UTC)
    assert switched(path, None) == {}
    assert switched(path, 2) == {"3": False}  # "1" has switched it on again
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("UPDATE event SET body = replace(body, 'altered', 'changed') WHERE number = 7")
    assert switched(path, None) == {"3": False}  # "1" is off in what was kept
    assert switched(path, 2) == {"1": False, "3": False}
    assert switched(path, 1) == {"1": False, "3": False}
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("UPDATE event SET body = '' WHERE number = 8")
    assert switched(path, None) == {"2": False, "": False}  # who switched it off then is not known


def switched(path: Path, cycle: int | None) -> dict[str, bool]:
    """Who is switched off or on after what was copied, and that who was here is here again."""
    into = path.with_name("recovered.fatplan")
    into.unlink(missing_ok=True)
    kept = recover(path, into, cycle)
    here = [one.event.worker for one in kept if isinstance(one.event, WorkerChanged)][-1:] or [""]
    found: dict[str, bool] = {}
    now = here
    for one in read_journal(into)[len(kept) + 1 :]:
        match one.event:
            case WorkerChanged(worker=worker):
                now = [worker]
            case Advice(on=on):
                found[now[0]] = on
    assert now == here
    return found


def test_what_is_no_journal_is_refused(path: Path, tmp_path: Path) -> None:
    with pytest.raises(OutputFolderError, match="there is no such journal"):
        read_journal(path)
    with pytest.raises(OutputFolderError, match="there is no such folder"):
        Journal(tmp_path / "none" / "shift.fatplan")
    path.write_bytes(b"not a database at all, though long enough to be one" * 100)
    with pytest.raises(DamagedJournalError):
        Journal(path)
    path.unlink()
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("CREATE TABLE event (number)")
    with pytest.raises(OutputFolderError, match="is no journal of fatplan"):
        Journal(path)


def opening(session: str, **other: object) -> Opened:
    """The first event of a shift, which nothing can be gone on with."""
    content = {
        "format": FORMAT, "session": session, "scenario": "", "scenario_name": "", "actions": (), "policy": {},
        "policy_sources": {}, "safe_action": "", "deadline_s": 0.05, "versions": {"fatplan": "9.9"}, "origin": "",
    }  # fmt: skip
    return Opened.model_validate(content | other)


def test_another_format_is_named(path: Path) -> None:
    with Journal(path) as journal:
        journal.append(opening("", format=99), 0.0, UTC)
    with pytest.raises(OtherVersionError, match=r"format 99.*go on with fatplan 9.9"):
        read_journal(path)

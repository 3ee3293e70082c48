"""`fatplan live`: the journal as a table, what is intact of it, and a worker erased."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pandas as pd
import pytest
from commands import fatplan

from fatigue_planner.live.events import Noted, Observed, Recovered
from fatigue_planner.live.journal import Journal
from fatigue_planner.live.journal_file import pseudonyms, read_journal

SAID = [
    Noted(text="begin, with a comma"),
    Observed(cycle=1, executed="low", observation="arm"),
    Observed(cycle=2, executed="high", likelihood={"arm": 0.9, "back": 0.1}, duration_s=17.5),
]


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    path = tmp_path / "shift.fatplan"
    with Journal(path) as written:
        written.join("77aa", "w-7f3a")
        for number, event in enumerate(SAID):
            written.append(event, float(number), "2026-11-28T12:00:00+00:00")
    return path


def test_events_become_a_table(journal: Path, tmp_path: Path) -> None:
    done = fatplan("live", "export", journal, tmp_path / "shift.csv")
    assert (done.returncode, done.stdout) == (0, f"{tmp_path / 'shift.csv'}: 3 events.\n")
    table = pd.read_csv(tmp_path / "shift.csv")
    assert table["kind"].tolist() == ["noted", "observed", "observed"]
    assert table["cycle"].tolist()[1:] == [1, 2]
    assert json.loads(table["likelihood"][2]) == {"arm": 0.9, "back": 0.1}
    assert table["text"][0] == "begin, with a comma"
    assert "w-7f3a" not in (tmp_path / "shift.csv").read_text()


def test_events_become_lines_of_json(journal: Path, tmp_path: Path) -> None:
    done = fatplan("live", "export", journal, tmp_path / "shift.jsonl", "--json")
    assert json.loads(done.stdout) == {"file": str(tmp_path / "shift.jsonl"), "events": 3}
    rows = [json.loads(line) for line in (tmp_path / "shift.jsonl").read_text().splitlines()]
    assert [
        Observed(**{k: v for k, v in row.items() if k not in ("number", "seconds", "utc")}) for row in rows[1:]
    ] == SAID[1:]


def test_the_form_must_be_known(journal: Path, tmp_path: Path) -> None:
    done = fatplan("live", "export", journal, tmp_path / "shift.txt")
    assert done.returncode == 2
    assert "should end in .csv or .jsonl, or give --format" in done.stderr
    assert fatplan("live", "export", journal, tmp_path / "shift.txt", "--format", "csv").returncode == 0


def test_what_is_intact_is_recovered(journal: Path, tmp_path: Path) -> None:
    with closing(sqlite3.connect(journal, isolation_level=None)) as connection:
        connection.execute("UPDATE event SET utc = 'x' WHERE number = 2")
    done = fatplan("live", "export", journal, tmp_path / "shift.csv")
    assert done.returncode == 4
    assert (
        f"Intact are 2 events, up to cycle 1. Nothing was changed. `fatplan live recover {journal} NEW`" in done.stderr
    )
    done = fatplan("live", "recover", journal, tmp_path / "new.fatplan")
    assert (done.returncode, done.stdout) == (0, f"{tmp_path / 'new.fatplan'}: 2 events.\n")
    copied = [one.event for one in read_journal(tmp_path / "new.fatplan")]
    assert copied == [*SAID[:2], Recovered(intact=2, kept=2, cycle=2)]
    assert pseudonyms(tmp_path / "new.fatplan") == {"77aa": "w-7f3a"}
    done = fatplan("live", "recover", journal, tmp_path / "new.fatplan")
    assert done.returncode == 2
    assert "is there already; choose another name" in done.stderr


def test_a_worker_is_erased(journal: Path) -> None:
    done = fatplan("live", "erase", journal, "w-7f3a")
    assert (done.returncode, done.stdout) == (0, f"{journal}: w-7f3a is erased.\n")
    done = fatplan("live", "erase", journal, "w-7f3a")
    assert done.returncode == 2
    assert "no worker has the pseudonym 'w-7f3a'" in done.stderr
    assert [one.event for one in read_journal(journal)] == SAID


@pytest.mark.parametrize("command", [["export", "x.csv"], ["recover", "new"], ["erase", "w-1"]], ids=lambda c: c[0])
def test_a_missing_journal_is_named(tmp_path: Path, command: list[str]) -> None:
    done = fatplan("live", command[0], tmp_path / "none", *command[1:])
    assert done.returncode == 2
    assert f"{tmp_path / 'none'}: there is no such journal" in done.stderr
    assert list(tmp_path.iterdir()) == []

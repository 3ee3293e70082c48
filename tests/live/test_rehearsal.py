"""A rehearsal: a server that does what is right passes with every fault, and one that does not is found out."""

import json
import subprocess
from pathlib import Path

import pytest
from commands import fatplan, finished, process
from conftest import PAPER

import fatigue_planner as fp
from fatigue_planner.core.errors import FaceUnreachableError, SelectionError, WorkerError
from fatigue_planner.live.clients.connection import Address, Connection
from fatigue_planner.live.events import Opened
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.rehearsal.registry import FAULTS
from fatigue_planner.live.rehearsal.rehearse import rehearse
from fatigue_planner.live.rules import DEFAULT_POLICY
from fatigue_planner.planners.registry import policy

COMMAND = ("live", "rehearse", "paper", "--condition", "multiple_novice")


@pytest.fixture(scope="module")
def scenario(cache_folder: Path) -> fp.Scenario:
    experiment = fp.load(PAPER)
    return fp.scenario(experiment, fp.simulate(experiment, cache_folder), "multiple_novice")


def test_options_are_checked_before_anything_is_done(tmp_path: Path, cache_folder: Path) -> None:
    for words, message in {
        ("--fault", "flood"): "--fault flood: there is no such fault; available: tracker_silent,",
        ("--fault", "pause=often"): "--fault pause=often: should be pause=RATE with a rate from 0 to 1.",
        ("--fault", "pause=nan"): "--fault pause=nan: should be pause=RATE",
        ("--fault", "pause=0.6", "--fault", "tracker_late=0.5"): "the rates' sum is 1.1; at most 1 fault",
        ("--condition", "nobody"): "--condition nobody: not in the experiment's benchmark",
    }.items():
        done = fatplan(*COMMAND, *words, "--cache", cache_folder, cwd=tmp_path)
        assert (done.returncode, message in done.stderr) == (2, True), done.stderr
    (tmp_path / "rehearsal.fatplan").touch()
    done = fatplan(*COMMAND, "--cache", cache_folder, cwd=tmp_path)
    assert (done.returncode, "is there already" in done.stderr) == (2, True)


@pytest.mark.slow
def test_every_fault_is_met_as_it_should(tmp_path: Path, cache_folder: Path) -> None:
    """All faults, more often than in a shift; the journal is marked, and a real shift cannot go on with it."""
    rates = dict.fromkeys(FAULTS, 0.07) | {"server_killed": 0.03}
    asked = [word for name, rate in rates.items() for word in ("--fault", f"{name}={rate}")]
    folder = ("--cache", cache_folder, "--journal", tmp_path / "rehearsal.fatplan")
    running = process(*COMMAND, "--cycles", 130, "--json", *asked, *folder)
    out, err = running.communicate(timeout=900)
    done = subprocess.CompletedProcess(running.args, running.returncode, out, err)
    assert done.returncode == 0, done.stdout + done.stderr
    came = json.loads(done.stdout)
    assert (came["right"], came["belief_is_right"], came["wrong_inputs"]) == (True, True, [])
    assert came["cycles"] >= 130
    assert "simulated workers" in (Path(came["report"]) / "report.html").read_text()
    assert {row["fault"] for row in came["rows"] if row["times"]} == set(FAULTS)
    events = read_journal(tmp_path / "rehearsal.fatplan")
    assert isinstance(events[0].event, Opened)
    assert events[0].event.rehearsal
    assert events[-1].event.kind == "closed"
    done = finished("live", "serve", "paper", "--condition", "multiple_novice", "--port", 0, *folder)
    assert done.returncode == 2
    assert "the clock (the machine's, or a rehearsal's) changed" in done.stderr


# By the fault that must notice it, what is broken in the server.
BROKEN = {
    "robot_other_pose": "Session._doing = lambda self, decided: decided\nSession.executed = lambda self, cycle, "
    "action=None: self.decide()",
    "tracker_contradictory": "Session._contradict = lambda self, event, why: None",
    "tracker_late": "import fatigue_planner.live.shift as shift\n"
    "shift.Shift._correct = lambda self, event: None",
    "pause": "take = Session.rest\nSession.rest = lambda self, seconds, key: take(self, seconds / 2, key)",
    "worker_swaps": "import fatigue_planner.live.shift as shift\nchange = shift.Shift._change\n"
    "def same(self, event):\n    belief = self.belief\n    change(self, event)\n    self.belief = belief\n"
    "shift.Shift._change = same",
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_server_is_found_out(fault: str, tmp_path: Path, cache_folder: Path, scenario: fp.Scenario) -> None:
    plugin = tmp_path / "broken.py"
    plugin.write_text(f"from fatigue_planner.live.session import Session\n{BROKEN[fault]}\n")
    options = [str(PAPER), "--condition", scenario.name, "--cache", str(cache_folder), "--plugin", str(plugin)]
    came = rehearse(tmp_path / "journal", scenario, policy(DEFAULT_POLICY), options, 12, {fault: 0.5}, seed=3)
    assert came.rows[0].times > 0
    assert not came.is_right


@pytest.mark.slow
def test_a_server_that_does_not_start_is_told(tmp_path: Path, scenario: fp.Scenario) -> None:
    options = [str(PAPER), "--condition", scenario.name, "--cache", str(tmp_path)]
    with pytest.raises(WorkerError, match=r"did not start: .*fatplan simulate"):
        rehearse(tmp_path / "journal", scenario, policy(DEFAULT_POLICY), options, 5, {}, seed=1)


def test_where_a_face_may_be(tmp_path: Path) -> None:
    for url in ("127.0.0.1:8765", "http://127.0.0.1", "ftp://127.0.0.1:1", "http://[::1", "http://127.0.0.1:1/x", ""):
        with pytest.raises(SelectionError, match="should be an address such as"):
            Address(url, tmp_path)
    with pytest.raises(SelectionError, match="needs https"):
        Address("http://192.0.2.1:8765", tmp_path)
    assert Address("https://192.0.2.1:8765", tmp_path).connect(1.0).host == "192.0.2.1"
    nowhere = Connection(Address("http://127.0.0.1:9", tmp_path / "none"), patience_s=0.0)
    with pytest.raises(FaceUnreachableError, match="holds no token"):
        nowhere.decide()

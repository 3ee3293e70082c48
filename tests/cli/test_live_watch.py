"""`fatplan live watch`: what a terminal shows, and a server that goes away."""

import re
import select
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import IO

import pytest
from commands import process, refused
from servers import start
from shifts import CYCLE_S, World

import fatigue_planner as fp
from fatigue_planner.cli.watch import essence, lines, read
from fatigue_planner.live.state import SessionState


@contextmanager
def bent(world: World) -> Iterator[SessionState]:
    """The state after cycles with a bent back."""
    with world.open(alarms=fp.AlarmSettings(limit=0.25)) as session:
        for _ in range(20):
            decision = session.decide()
            world.clock.pass_(CYCLE_S)
            session.observe(decision.cycle, executed="low", observation="back")
        session.decide()
        yield session.state()


def test_what_is_shown(world: World) -> None:
    with bent(world) as state:
        shown = "\n".join(lines(state, 0.2))
        assert re.search(r"take a pause of \d+ s: lumbar lateral, negative above 0.25 \(100%\)", shown)
        assert re.search(r"^Cycle 21    next pose: (high|low)$", shown, re.MULTILINE)
        assert re.search(r"^lumbar lateral, negative +0\.\d\d \(.*\) +\d+ s$", shown, re.MULTILINE)
        assert "work design: no pose keeps right wrist deviation, positive below 0.25" in shown
        assert "not seen 0 (0 in a row)   late 0" in shown
        assert "No safety function." in shown
        assert "No news" not in shown
        assert lines(state, 7)[0] == "No news for 7 s: what is shown is old"
        assert "model: fits, 0 surprises in the last 20 cycles that were seen" in shown
        assert "model: off" in lines(replace(state, advised=False), 0)
        wrong = replace(state, fault="disk full", robot="unreachable", fallback="schedule", fits=False, rehearsal=False,
                        degraded=True, surprises=11, judged=50)  # fmt: skip
        wrong.counts.unseen_in_a_row = 3
        assert essence(wrong, 0).split("; ")[1:6] == [
            "the robot does not say what it does",
            "not recorded: disk full",
            "degraded: not seen for 3 cycles",
            "fallback: schedule",
            "the model does not fit this worker: 11 surprises in the last 50 cycles that were seen",
        ]
        assert essence(state, 6) == essence(None, 0) == "no news"


def test_a_state_is_read_as_it_was_sent(world: World) -> None:
    with bent(world) as state:
        assert read({**asdict(state), "watchers": 3}) == state
        assert read({"cycle": 3}) is None


def test_what_cannot_be_watched_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "shift.fatplan.view-token: holds no token" in refused(3, "live", "watch")
    assert "should be an address such as" in refused(2, "live", "watch", "--server", "here")


def line_with(words: str, stream: IO[str]) -> str:
    """The next line with these words, in a minute at most."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        if select.select([stream], [], [], 1.0)[0] and words in (line := stream.readline()):
            return line
    raise AssertionError(f"{words} did not come")


@pytest.mark.slow
def test_a_server_that_goes_away_is_waited_for(tmp_path: Path, cache_folder: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    journal = tmp_path / "shift.fatplan"
    address = ("--server", f"http://127.0.0.1:{port}", "--token-file", f"{journal}.view-token")
    server = start(journal, cache_folder, "--port", port)
    watching = process("live", "watch", *address, env={"PYTHONUNBUFFERED": "1"}, bufsize=1)
    with server.process, watching:
        assert watching.stdout is not None
        server.call("/v1/decide", {})
        line_with("cycle 1: ", watching.stdout)
        server.call("/v1/observe", {"cycle": 1, "observation": "arm"})
        line_with("cycle 2: ", watching.stdout)
        server.process.kill()
        line_with("no news", watching.stdout)
        server.process.wait()
        again = start(journal, cache_folder, "--port", port)  # with new tokens
        with again.process:
            again.call("/v1/decide", {})
            line_with("cycle 2: ", watching.stdout)
            again.process.kill()
        watching.kill()

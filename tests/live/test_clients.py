"""What a robot's client believes: scripted echoes, and what it then says to the face."""

import json
import runpy
import subprocess
import sys
import threading
import time
import urllib.error
from collections.abc import Callable
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

from fatigue_planner.core.errors import FaceRefusedError, SelectionError
from fatigue_planner.live.clients.connection import Address, Answer, Connection, is_state
from fatigue_planner.live.clients.robot import Echo, RobotClient, RobotLink


class Scripted(RobotLink):
    """A robot that says what the test sets; what is written to it always seems to arrive."""

    def __init__(self) -> None:
        self.echo: Echo | None = Echo(0, 0, 0)
        self.written: list[tuple[int, int]] = []
        self.is_on = True

    def connect(self) -> bool:
        return self.is_on

    def write(self, pose: int, cycle: int) -> None:
        self.written.append((pose, cycle))

    def read(self) -> Echo | None:
        return self.echo

    def close(self) -> None:
        pass


class Recorder:
    """Stands in for the connection: what was said."""

    def __init__(self) -> None:
        self.said: list[tuple[str, dict[str, Any]]] = []

    def call(self, name: str, **said: Any) -> Answer | None:
        self.said.append((name, said))
        return None

    def close(self) -> None:
        pass


@pytest.fixture
def robot(tmp_path: Path) -> tuple[RobotClient, Scripted, Recorder]:
    link, recorder = Scripted(), Recorder()
    client = RobotClient(Address("http://127.0.0.1:1", tmp_path), link, ("high", "low"), grace_s=0.0)
    client.connection = recorder  # type: ignore[assignment]
    return client, link, recorder


Robot = tuple[RobotClient, Scripted, Recorder]


def silent_for_a_cycle(robot: Robot) -> None:
    """It echoes the first cycle, and nothing of the second, though it is written to."""
    client, link, recorder = robot
    client.look(1, "low")
    link.echo = Echo(2, 1, 0)
    client.look(1, "low")
    client.look(2, "high")
    client.look(3, "high")
    assert link.written == [(2, 1), (1, 2), (1, 3)]
    assert recorder.said == [("executed", {"cycle": 1, "action": "low"}), ("executed", {"cycle": 3})]


def test_28_what_is_written_is_not_delivered(robot: Robot, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    silent_for_a_cycle(robot)

    def believed(self: RobotClient, echo: Echo, cycle: int) -> None:
        assert self._written is not None
        hear(self, Echo(*self._written, echo.asked), cycle)

    hear = RobotClient._hear
    monkeypatch.setattr(RobotClient, "_hear", believed)  # the planted fault: what was written counts
    link, recorder = Scripted(), Recorder()
    client = RobotClient(Address("http://127.0.0.1:1", tmp_path), link, ("high", "low"))
    client.connection = recorder  # type: ignore[assignment]
    with pytest.raises(AssertionError):
        silent_for_a_cycle((client, link, recorder))


@pytest.mark.parametrize("absurd", [Echo(3, 2, 0), Echo(-1, 2, 0), Echo(1, 3, 0), Echo(1, -4, 0), Echo(2**31, 2, 0)])
def test_what_cannot_be_is_ignored_and_counted_once(robot: Robot, absurd: Echo) -> None:
    client, link, recorder = robot
    link.echo = absurd
    client.look(2, "low")
    client.look(2, "low")
    assert recorder.said == []
    assert sum(client.ignored.values()) == 1


def test_late_double_and_lost_echoes(robot: Robot) -> None:
    client, link, recorder = robot
    client.look(1, "low")
    client.look(2, "low")
    assert recorder.said == [("executed", {"cycle": 2})]
    link.echo = Echo(1, 1, 0)  # late, and another pose
    client.look(2, "low")
    client.look(2, "low")
    link.echo = Echo(2, 2, 0)
    client.look(2, "low")
    assert recorder.said[1:] == [
        ("executed", {"cycle": 1, "action": "high"}), ("executed", {"cycle": 2, "action": "low"}),
    ]  # fmt: skip
    link.echo, link.is_on = None, False
    client.look(2, "low")
    client.look(2, "low")
    assert recorder.said[3:] == [("executed", {"cycle": 2})]


def test_the_robot_asks_for_the_next_cycle(robot: Robot) -> None:
    client, link, recorder = robot
    link.echo = Echo(2, 1, 2)
    client.look(1, "low")
    link.echo = Echo(0, 2, 3)
    client.look(2, "low")
    assert recorder.said == [
        ("executed", {"cycle": 1, "action": "low"}), ("decide", {"cycle": 2}), ("skip", {"cycle": 2}),
    ]  # fmt: skip


def test_every_action_must_have_been_taught(robot: Robot) -> None:
    client, _, _ = robot
    client.check(("low", "high"), ("arm",))
    with pytest.raises(SelectionError, match="should name every action"):
        client.check(("low", "high", "middle"), ("arm",))


RIGHT = {
    "cycle": 1, "action": "low", "actions": ["high", "low"], "reactions": ["arm"], "rehearsal": False, "resumed_at": -1,
}  # fmt: skip
ABSURD = [
    *({key: value for key, value in RIGHT.items() if key != missing} for missing in RIGHT if missing != "action"),
    RIGHT | {"actions": "high"}, RIGHT | {"actions": [1]}, RIGHT | {"action": "middle"}, RIGHT | {"reactions": None},
    RIGHT | {"cycle": "1"}, RIGHT | {"rehearsal": "no"}, [RIGHT], None, 7,
]  # fmt: skip


class Absurd(BaseHTTPRequestHandler):
    """Another program at the face's address, whose events are absurd; the last ones are a shift's."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()
        other = RIGHT | {"actions": ["high", "low", "middle"], "action": "middle", "cycle": 2}
        for content in [*ABSURD, RIGHT, other]:
            self.wfile.write(f"data: {json.dumps(content)}\n\n".encode())
            self.wfile.flush()
            if content == RIGHT:
                time.sleep(0.5)
        time.sleep(2)

    def log_message(self, *_: object) -> None:
        pass


def test_a_state_that_is_none_is_not_believed(tmp_path: Path) -> None:
    """Only a whole state is looked at; one with other actions is checked anew, without a word between them."""
    assert is_state(RIGHT) and is_state(RIGHT | {"action": None})
    assert not any(is_state(content) for content in ABSURD)
    token = tmp_path / "token"
    token.write_text("secret")
    with ThreadingHTTPServer(("127.0.0.1", 0), Absurd) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        link = Scripted()
        client = RobotClient(Address(f"http://127.0.0.1:{server.server_port}", token), link, ("high", "low"))
        client.connection = Recorder()  # type: ignore[assignment]
        with pytest.raises(SelectionError, match="should name every action"):
            client.run(threading.Event())
        server.shutdown()
    assert link.written == [(2, 1)]


SLOW_S = 0.1


class Slow(BaseHTTPRequestHandler):
    """A face whose first answer comes late, and which then refuses twice; how long the client says it waited."""

    waited_s: list[float | None]

    def do_POST(self) -> None:
        said = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.waited_s.append(said.get("waited_s"))
        number = len(self.waited_s)
        if number == 1:
            time.sleep(SLOW_S)
        content = {"cycle": 1, "action": "low", "fallback": "none", "recorded": 1, "durable_up_to": 1}
        body = json.dumps(content if number not in (2, 3) else {"error": "no"}).encode()
        self.send_response(200 if number not in (2, 3) else 409)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        pass


def shipped(address: Address, _: pytest.MonkeyPatch) -> Callable[[], object]:
    return Connection(address).decide


def sketch(address: Address, monkeypatch: pytest.MonkeyPatch) -> Callable[[], object]:
    monkeypatch.setenv("FATPLAN_SERVER", address.url)
    monkeypatch.setenv("FATPLAN_TOKEN_FILE", str(address.token_file))
    ask = runpy.run_path(str(ROOT / "examples" / "clients" / "face.py"))["ask"]
    return lambda: ask("decide")


@pytest.mark.parametrize("client", [shipped, sketch])
def test_a_late_answer_is_told_once(client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where what tells it is refused: the face has counted it, and the refusal is the answer before the next."""
    token = tmp_path / "token"
    token.write_text("secret")
    Slow.waited_s = []
    with ThreadingHTTPServer(("127.0.0.1", 0), Slow) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        decide = client(Address(f"http://127.0.0.1:{server.server_port}", token), monkeypatch)
        for _ in range(4):
            with suppress(FaceRefusedError, urllib.error.HTTPError):
                decide()
        server.shutdown()
    first, *told = Slow.waited_s
    assert first is None and told[0] is not None and told[0] >= SLOW_S
    assert len(set(told)) == 3  # each its own time


def test_a_client_loads_nothing_of_the_shift() -> None:
    code = "import sys, fatigue_planner.live.clients.robot\nprint({'pydantic', 'numpy', 'numba'} & sys.modules.keys())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"

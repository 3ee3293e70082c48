"""The face of a session: a real server process; who may call, what may be sent, and that nobody can hurt the others."""

import http.client
import json
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from commands import FATPLAN, fatplan, finished
from servers import SERVE, Server, start

from fatigue_planner.core.errors import EvidenceError
from fatigue_planner.live.events import Observed
from fatigue_planner.live.face.app import Face
from fatigue_planner.live.face.description import openapi
from fatigue_planner.live.face.guard import MAX_REFUSALS_PER_S, OPEN_PATHS, REFUSAL_WAIT_S
from fatigue_planner.live.face.page import PAGE, PAGE_HEADERS
from fatigue_planner.live.face.requests import CALLS, parse
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.state import SessionState


@pytest.fixture(scope="module")
def server(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    running = start(tmp_path_factory.mktemp("face") / "shift.fatplan", cache_folder)
    with running.process:
        yield running
        running.process.kill()


def test_a_request_is_checked_field_by_field() -> None:
    with pytest.raises(EvidenceError, match=r"cycle: .*; duration: Extra inputs are not permitted"):
        parse(CALLS["observe"], b'{"cycle": "1", "duration": 3}')
    with pytest.raises(EvidenceError, match="seconds: Field required"):
        parse(CALLS["rest"], b"")
    with pytest.raises(EvidenceError, match="body: "):
        parse(CALLS["rest"], b"[" * 50_000)
    assert parse(CALLS["rest"], b'{"seconds": 3}').plain() == {"seconds": 3.0, "key": None, "waited_s": None}


def test_the_description_is_complete() -> None:
    """Every route with its methods, and nothing else; every schema that is pointed to is there."""
    described, face = openapi("1"), Face(None)  # type: ignore[arg-type]
    routes = {route.path: (route.methods or set()) - {"HEAD"} for route in face.routes()}
    assert {path: {name.upper() for name in methods} for path, methods in described["paths"].items()} == routes
    for path, call in described["paths"].items():
        for method in call.values():
            assert method["summary"].endswith(".")
            assert all(one["description"].endswith(".") for one in method["responses"].values())
            assert {"200", "421"} <= set(method["responses"])
            assert (path in OPEN_PATHS) == (method.get("security") == [])
            for field in method.get("requestBody", {}).values():
                fields = field["application/json"]["schema"]["properties"].values()
                assert all(one["description"].endswith(".") for one in fields)
    pointed = set(re.findall(r'"#/components/schemas/(\w+)"', json.dumps(described)))
    assert pointed <= set(described["components"]["schemas"])
    assert set(described["components"]["schemas"]["SessionState"]["properties"]) == {
        *SessionState.__dataclass_fields__,
        "watchers",
    }


def test_the_page_is_small_and_asks_nobody_else() -> None:
    assert len(PAGE.encode()) < 30_000
    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)", PAGE)
    assert "unsafe-inline" not in PAGE_HEADERS["content-security-policy"]
    assert PAGE_HEADERS["content-security-policy"].count("sha256-") == 2


def test_another_condition_is_refused(tmp_path: Path, cache_folder: Path) -> None:
    done = fatplan("live", "serve", "paper", "--condition", "nobody", "--cache", cache_folder, cwd=tmp_path)
    assert done.returncode == 2
    assert "--condition nobody: not in the experiment's benchmark; available: single_novice" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_cycle(server: Server) -> None:
    code, decision = server.call("/v1/decide", {})
    assert code == 200
    code, again = server.call("/v1/decide", {"cycle": decision["cycle"]})
    assert (code, again["action"]) == (200, decision["action"])
    code, following = server.call("/v1/observe", {"cycle": decision["cycle"], "observation": "arm"})
    assert (code, following["cycle"]) == (200, decision["cycle"] + 1)
    code, error = server.call("/v1/observe", {"cycle": decision["cycle"], "observation": "back"})
    assert (code, error["expected_cycle"]) == (409, decision["cycle"] + 1)
    code, error = server.call("/v1/observe", {"cycle": 900, "observation": "back"})
    assert code == 422
    assert "the cycle going on is" in error["error"]
    assert server.call("/v1/rest", {"seconds": 60})[0] == 200
    assert server.call("/v1/note", {"text": "tool changed"}) == (200, None)
    for waited_s in (0.049, 0.051, 3.0):  # the deadline is 0.05 s
        assert server.call("/v1/decide", {"waited_s": waited_s})[0] == 200
    code, error = server.call("/v1/decide", {"waited_s": -1.0})
    assert (code, error["error"][:14]) == (422, "waited_s -1.0:")
    code, state = server.call("/v1/state", token=server.view)
    assert code == 200
    assert state["cycle"] == following["cycle"]
    assert (state["counts"]["contradicted"], state["counts"]["late"], state["counts"]["came_late"]) == (1, 0, 2)
    assert {joint["entry"] for joint in state["joints"]} >= {"lumbar_flexion:positive"}


@pytest.mark.slow
def test_who_may_not_is_refused(server: Server) -> None:
    before = server.call("/v1/state")[1]["cycle"]
    assert server.call("/v1/state", token="")[0] == 401
    assert server.call("/v1/state", token="x" * 43)[0] == 401
    assert server.call("/v1/state", token="ä")[0] == 401
    assert server.call("/v1/skip", {}, token=server.view)[0] == 403
    assert server.call("/v1/skip", {}, Origin="http://evil.example")[0] == 403
    assert server.call("/v1/skip", {}, Origin="null")[0] == 403
    assert server.call("/v1/state", Host="evil.example")[0] == 421
    assert server.call("/v1/state", Host=f"evil.example:{server.port}")[0] == 421
    assert server.call("/v1/note", {"text": "x" * 70_000})[0] == 413
    assert server.call("/v1/skip", method="DELETE")[0] == 405
    assert server.call("/v1/nothing")[0] == 404
    for path in ("/", "/healthz", "/openapi.json"):
        assert server.call(path, token="")[0] == 200
    assert server.call("/v1/state")[1]["cycle"] == before
    begin = time.monotonic()
    for _ in range(MAX_REFUSALS_PER_S * 2 + 2):  # of two seconds, if it is slow
        assert server.call("/v1/state", token="")[0] == 401
    assert time.monotonic() - begin > REFUSAL_WAIT_S


def watch(server: Server) -> bytes:
    """A request for events."""
    lines = ["GET /v1/events HTTP/1.1", f"Host: 127.0.0.1:{server.port}", f"Authorization: Bearer {server.view}"]
    return "\r\n".join([*lines, "", ""]).encode()


def mutated(rng: np.random.Generator) -> bytes:
    """A body that is nearly right."""
    whole = json.dumps({"cycle": int(rng.integers(-2, 40)), "observation": "arm", "duration_s": 16.0}).encode()
    kind = rng.integers(4)
    if kind == 0:
        return rng.bytes(int(rng.integers(200)))
    if kind == 1:
        values = [None, True, -1, 1e400, "x", [], {}, 10**30, 0.5, "\0", {"arm": 1e308}]
        names = [
            "cycle",
            "executed",
            "observation",
            "likelihood",
            "duration_s",
            "seconds",
            "pseudonym",
            "on",
            "text",
            "?",
        ]
        return json.dumps({str(rng.choice(names)): values[rng.integers(len(values))] for _ in range(3)}).encode()
    place = int(rng.integers(len(whole)))
    return whole[:place] + rng.bytes(1) + whole[place + int(kind == 2) :]


@pytest.mark.slow
def test_anything_may_be_sent(server: Server) -> None:
    """10,000 bodies: every answer has a status that says what was wrong, and the session stands."""
    rng = np.random.default_rng(7)
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    codes: dict[int, int] = {}
    for _ in range(10_000):
        path = f"/v1/{rng.choice(list(CALLS))}"
        connection.request("POST", path, mutated(rng), {"Authorization": f"Bearer {server.act}"})
        answer = connection.getresponse()
        answer.read()
        codes[answer.status] = codes.get(answer.status, 0) + 1
    connection.close()
    assert set(codes) <= {200, 409, 422}
    assert codes[422] > 5_000
    assert server.call("/v1/state")[0] == 200


@pytest.mark.slow
def test_the_page_gets_the_newest_state(server: Server) -> None:
    with socket.create_connection(("127.0.0.1", server.port), timeout=10) as watching:
        request = (
            f"GET /v1/events HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nAuthorization: Bearer {server.view}\r\n\r\n"
        )
        watching.sendall(request.encode())
        text = ""
        while text.count("data: ") < 1:
            text += watching.recv(65_536).decode()
        code, decision = server.call("/v1/decide", {})
        assert code == 200
        server.call("/v1/observe", {"cycle": decision["cycle"]})
        begin = time.monotonic()
        while f'"cycle":{decision["cycle"] + 1},' not in text:
            text += watching.recv(65_536).decode()
        assert time.monotonic() - begin < 5


@pytest.mark.slow
def test_slow_and_many_clients_hurt_nobody(server: Server) -> None:
    """1,000 connections that say nothing or half a request, or never read: a good client is answered."""
    good = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    headers = {"Authorization": f"Bearer {server.act}"}

    def answered() -> float:
        begin = time.perf_counter()
        good.request("POST", "/v1/decide", b"{}", headers)
        answer = good.getresponse()
        assert answer.status == 200
        answer.read()
        return time.perf_counter() - begin

    answered()
    bad = []
    try:
        for number in range(1000):
            one = socket.socket()
            one.settimeout(2)
            bad.append(one)
            try:
                one.connect(("127.0.0.1", server.port))
                if number % 3 == 1:
                    one.sendall(b"POST /v1/decide HTTP/1.1\r\nHo")
                elif number % 3 == 2:
                    one.sendall(watch(server))
            except OSError:
                pass
        assert max(answered() for _ in range(200)) < 2
        time.sleep(6)  # those that have not sent whole requests are closed
        assert server.call("/v1/state")[0] == 200
        assert server.call("/v1/state")[1]["watchers"] <= 50
    finally:
        for one in bad:
            one.close()
        good.close()


@pytest.mark.slow
def test_a_killed_server_goes_on(tmp_path: Path, cache_folder: Path) -> None:
    journal = tmp_path / "shift.fatplan"
    server = start(journal, cache_folder)
    with server.process:
        decision = server.call("/v1/decide", {})[1]
        for _ in range(3):
            decision = server.call("/v1/observe", {"cycle": decision["cycle"], "observation": "arm"})[1]
        while server.call("/v1/state")[1]["durable_up_to"] < decision["recorded"]:
            time.sleep(0.05)
        server.process.kill()
    server = start(journal, cache_folder)
    with server.process:
        again = server.call("/v1/decide", {"cycle": 4})[1]
        assert (again["cycle"], again["action"]) == (4, decision["action"])
        second = finished(*SERVE, "--journal", journal, "--cache", cache_folder)
        assert second.returncode == 2
        assert f"is being written by process {server.process.pid} since" in second.stderr
        server.process.send_signal(signal.SIGINT)
        assert server.process.wait(30) == 130
    assert read_journal(journal)[-1].event.kind == "closed"
    assert sum(isinstance(one.event, Observed) for one in read_journal(journal)) == 3


def test_the_extra_is_named(tmp_path: Path) -> None:
    program = (
        "import sys; sys.modules['uvicorn'] = None; sys.argv = ['fatplan', 'live', 'serve', 'paper']\n" + FATPLAN[2]
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "pip install 'fatigue-planner[live]'" in done.stderr

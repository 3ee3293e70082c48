"""Clients of a real server: who says things twice, wrongly, too much, too slowly, or may not."""

import http.client
import json
import socket
import time
from collections import Counter
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import pytest
from planting import fails_with
from servers import Server
from shifts import World

from fatigue_planner.live.events import Contradicted, Observed, Refused
from fatigue_planner.live.journal_file import read_journal

pytestmark = pytest.mark.slow
SESSION = "fatigue_planner.live.session:Session"


def working(server: Server, cycles: int) -> dict[str, int]:
    """Work some cycles; the last decision."""
    decision = server.call("/v1/decide", {})[1]
    for _ in range(cycles):
        code, decision = server.call("/v1/observe", {"cycle": decision["cycle"], "observation": "arm"})
        assert code == 200
    return dict(decision)


@fails_with("fatigue_planner.live.said:says_the_same", '"late": False', '"late": True')
def test_05_said_twice(world: World) -> None:
    with world.serving() as server:
        decision = working(server, 2)
        again = server.call("/v1/observe", {"cycle": 2, "observation": "arm"})
        assert again[0] == 200
        assert (again[1]["cycle"], again[1]["action"]) == (decision["cycle"], decision["action"])
    assert [one.cycle for one in world.events(Observed)] == [1, 2]


@fails_with(f"{SESSION}._contradict", "self._tell(", "(")
def test_06_said_otherwise(world: World) -> None:
    with world.serving() as server:
        decision = working(server, 2)
        code, answer = server.call("/v1/observe", {"cycle": 2, "observation": "back"})
        assert (code, answer.get("expected_cycle")) == (409, 3)
        state = server.call("/v1/state")[1]
        assert (state["action"], state["counts"]["contradicted"]) == (decision["action"], 1)
    assert [one.observation for one in world.events(Observed)] == ["arm", "arm"]
    assert [json.loads(one.said)["observation"] for one in world.events(Contradicted)] == ["back"]


@fails_with("fatigue_planner.live.said:check_cycle", "shift.recent(cycle) is None", "cycle < 0")
def test_08_said_of_another_cycle(world: World) -> None:
    with world.serving() as server:
        working(server, 60)
        before = server.call("/v1/state")[1]
        for cycle in (66, 11):
            code, answer = server.call("/v1/observe", {"cycle": cycle, "observation": "arm", "executed": "low"})
            assert (code, answer.get("expected_cycle")) == (422, 61)
            assert "the cycle going on is 61" in answer["error"]
        after = server.call("/v1/state")[1]
        assert (after["recorded"], after["joints"]) == (before["recorded"], before["joints"])


@fails_with("fatigue_planner.live.said:likelihoods", "not 0 <= value <= 1", "value < 0")
def test_13_said_what_is_no_observation(world: World) -> None:
    """NaN, infinity, too large and too much: 422, which names the field; nothing changes. 10,000 more: test_face.py."""
    with world.serving() as server:
        working(server, 1)
        before = server.call("/v1/state")[1]["recorded"]
        huge = b'{"cycle": 2, "observation": "' + b"x" * 70_000 + b'"}'
        assert server.call("/v1/observe", huge)[0] == 413
        for value in ("NaN", "Infinity", "-0.1", "0", "1e308", '"1"', "true", "null", "[]", "1e999"):
            body = f'{{"cycle": 2, "likelihood": {{"arm": {value}}}}}'.encode()
            code, answer = server.call("/v1/observe", body)
            assert code == 422, value
            assert "likelihood" in answer["error"] or "body" in answer["error"], answer
        for body in (b"[]", b"{", b"[" * 60_000, b"\xff", b'{"cycle": 2, "seen": 1}'):
            assert server.call("/v1/observe", body)[0] == 422
        state = server.call("/v1/state")[1]
        assert state["cycle"] == 2
        later = [one.event for one in read_journal(server.journal) if one.number > before]
        assert all(isinstance(one, Refused) for one in later)  # that is all that was noted


@fails_with("fatigue_planner.live.face.server:LimitedProtocol.connection_made", ">= MAX_CONNECTIONS", "< 0")
def test_19_clients_vanish_never_read_and_drip(world: World) -> None:
    """400 connections are kept; a good client goes on; memory does not grow with those who never read."""
    with world.serving() as server, ExitStack() as held:
        good = held.enter_context(closing(http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)))
        headers = {"Authorization": f"Bearer {server.act}"}
        good.request("POST", "/v1/decide", b"{}", headers)
        assert good.getresponse().read()
        watch = (
            f"GET /v1/events HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nAuthorization: Bearer {server.view}\r\n\r\n"
        )
        for number in range(600):
            one = held.enter_context(socket.socket())
            one.settimeout(2)
            try:
                one.connect(("127.0.0.1", server.port))
                one.sendall(watch.encode() if number < 20 else b"POST /v1/decide HTTP/1.1\r\nHo")
            except OSError:
                pass
        end = time.monotonic() + 4
        while established(server) > 401:  # those too many are closed as soon as the server sees them
            assert time.monotonic() < end
            time.sleep(0.1)
        for cycle in range(1, 400):
            if cycle == 200:
                memory = resident(server)
            good.request("POST", "/v1/observe", json.dumps({"cycle": cycle, "observation": "arm"}), headers)
            answer = good.getresponse()
            assert (answer.status, json.loads(answer.read())["cycle"]) == (200, cycle + 1)
        assert resident(server) - memory < 10_000


def resident(server: Server) -> int:
    """Memory in kB."""
    lines = Path(f"/proc/{server.process.pid}/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


def established(server: Server) -> int:
    """Connections that the server has."""
    lines = Path(f"/proc/{server.process.pid}/net/tcp").read_text(encoding="ascii").splitlines()
    rows = [line.split() for line in lines[1:]]
    return sum(row[1].endswith(f":{server.port:04X}") and row[3] == "01" for row in rows)


@fails_with("fatigue_planner.live.face.guard:Tokens.right", '"act" if may_act', '"act" if may_act or may_view')
def test_20_who_may_not(world: World) -> None:
    with world.serving() as server:
        decision = working(server, 1)
        body = {"cycle": decision["cycle"], "observation": "arm"}
        rng = np.random.default_rng(1)
        for code, options in (
            (401, {"token": ""}), (401, {"token": rng.bytes(16).hex()}), (403, {"token": server.view}),
            (421, {"Host": "evil.example"}), (403, {"Origin": "http://evil.example"}),
        ):  # fmt: skip
            assert server.call("/v1/observe", body, **options)[0] == code
        assert server.call("/v1/state")[1]["cycle"] == decision["cycle"]
        end = time.monotonic() + 20
        while server.call("/v1/state")[1]["counts"]["refused"] < 5:  # told once a second at most
            assert time.monotonic() < end
            time.sleep(0.1)
        assert server.call("/v1/observe", body)[0] == 200
    told = world.events(Refused)
    assert 2 <= len(told) <= 4
    assert sum((Counter(one.counts) for one in told), Counter()) == {"401": 2, "403": 2, "421": 1}

"""The sketches of clients: they compile, are short, and what talks to the face runs against a real one."""

import asyncio
import re
import socket
import struct
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from conftest import PAPER, ROOT

from fatigue_planner.live.events import Observed, Skipped
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.rehearsal.server import Server

SKETCHES = ROOT / "examples" / "clients"


def test_sketches_are_short_and_compile() -> None:
    found = sorted(SKETCHES.glob("*.py"))
    assert [one.stem for one in found] == ["face", "plc_gateway", "ros2_node", "xsens_reader"]
    for one in found:
        text = one.read_text()
        compile(text, one.name, "exec")
        lines = [line for line in text.partition('"""\n')[2].splitlines() if line.strip() and '"""' not in line]
        assert len(lines) <= 40, one.name


@pytest.fixture
def server(cache_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    options = [str(PAPER), "--condition", "multiple_novice", "--cache", str(cache_folder)]
    with Server(tmp_path / "shift.fatplan", options, rehearsal=False) as running:
        monkeypatch.setenv("FATPLAN_SERVER", running.address.url)
        monkeypatch.setenv("FATPLAN_TOKEN_FILE", str(running.address.token_file))
        monkeypatch.syspath_prepend(str(SKETCHES))
        monkeypatch.chdir(ROOT)
        yield running
        for name in ("face", "plc_gateway", "ros2_node", "xsens_reader"):
            sys.modules.pop(name, None)


def module(monkeypatch: pytest.MonkeyPatch, name: str, **contents: Any) -> None:
    """Stand in for a library that comes with a device."""
    made = ModuleType(name)
    vars(made).update(contents)
    monkeypatch.setitem(sys.modules, name, made)


class Node:
    """What the sketch uses of rclpy's."""

    def __init__(self, name: str) -> None:
        self.sent: list[Any] = []

    def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
        node = self

        class Publisher:
            def publish(self, message: Any) -> None:
                node.sent.append(message.data)

        return Publisher()

    def create_subscription(self, *_: object) -> None:
        pass

    def create_timer(self, *_: object) -> None:
        pass


class String:
    def __init__(self, data: str) -> None:
        self.data = data


class Plc:
    """Nodes of a PLC, which ends two cycles and then loses its connection."""

    def __init__(self) -> None:
        self.values = {"executed": 2, "seen": 2, "ended_cycle": 0}
        self.written: list[tuple[str, int]] = []

    def get_node(self, name: str) -> Any:
        plc, key = self, name.rpartition(".")[2]

        class Variable:
            async def read_value(self) -> int:
                return plc.values[key]

            async def write_value(self, value: int) -> None:
                plc.written.append((key, value))
                if key == "cycle":
                    if value == 7:
                        raise ConnectionError
                    plc.values |= {"ended_cycle": value, "executed": 2 if value == 5 else 0}

        return Variable()


def datagram(lean_m: float) -> bytes:
    """A datagram of 23 segments, of which T8 is half a metre above the pelvis and so far ahead of it."""
    header = struct.pack(">6sIBBIB11x", b"MXTP02", 1, 0x80, 23, 0, 0)[:24]
    header += bytes(24 - len(header))
    places = [(lean_m, 0.0, 1.5) if number == 5 else (0.0, 0.0, 1.0) for number in range(1, 24)]
    segments = [struct.pack(">i7f", number, *place, 1, 0, 0, 0) for number, place in enumerate(places, 1)]
    return header + b"".join(segments)


def test_without_a_server_they_go_on(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """What is not answered, and a message that says nothing, end no sketch; nothing is sent to the robot then."""
    with socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        monkeypatch.setenv("FATPLAN_SERVER", f"http://127.0.0.1:{closed.getsockname()[1]}")
        monkeypatch.syspath_prepend(str(SKETCHES))
        stand_in(monkeypatch)
        for is_there in (False, True):
            token = tmp_path / "token"
            if is_there:
                token.write_text("secret")
            monkeypatch.setenv("FATPLAN_TOKEN_FILE", str(token))
            for name in ("face", "ros2_node", "plc_gateway", "xsens_reader"):
                sys.modules.pop(name, None)
            import plc_gateway
            import ros2_node
            import xsens_reader

            node = ros2_node.Fatplan()
            node.tell()
            for message in ("2 low", "low", ""):
                node.executed(String(message))
                node.reaction(String(message))
            assert node.sent == []
            with pytest.raises(TimeoutError):
                asyncio.run(asyncio.wait_for(plc_gateway.follow(plc := Plc()), 0.3))
            assert plc.written == []
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening:
                listening.bind(("127.0.0.1", 0))
                listening.settimeout(0.05)
                listening.sendto(datagram(0.5), listening.getsockname())
                with pytest.raises(TimeoutError):
                    xsens_reader.follow(listening)
    for name in ("face", "plc_gateway", "ros2_node", "xsens_reader"):
        sys.modules.pop(name, None)


def stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand in for the libraries of all devices."""
    module(monkeypatch, "rclpy")
    module(monkeypatch, "rclpy.node", Node=Node)
    module(monkeypatch, "std_msgs")
    module(monkeypatch, "std_msgs.msg", String=String)
    module(monkeypatch, "asyncua", Client=Plc)


@pytest.mark.slow
def test_what_talks_to_the_face_runs(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each sketch lives through a cycle or two of one shift."""
    stand_in(monkeypatch)
    import face
    import plc_gateway
    import ros2_node
    import xsens_reader

    page = (ROOT / "docs" / "clients.md").read_text()
    (snippet,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    shown: dict[str, Any] = {}
    exec(snippet, shown)
    assert shown["decision"]["cycle"] == 2

    node = ros2_node.Fatplan()
    node.tell()
    assert node.sent == [f"2 {face.ask('decide')['action']}"]
    node.executed(String("2 low"))
    node.reaction(String("2 arm"))
    for refused in ("2 arm leg", "2 nowhere", "99 arm", "arm", ""):
        node.executed(String(refused))
        node.reaction(String(refused))

    assert xsens_reader.trunk_deg(datagram(0.0)) == pytest.approx(0)
    assert xsens_reader.trunk_deg(datagram(0.5)) == pytest.approx(45)
    assert xsens_reader.trunk_deg(b"MXTP02 half") is xsens_reader.trunk_deg(b"MXTP25" + bytes(800)) is None
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening:
        listening.bind(("127.0.0.1", 0))
        listening.settimeout(3)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as suit:
            done = threading.Event()

            def move() -> None:
                for number in range(40):
                    suit.sendto(datagram(0.5), listening.getsockname())
                    if number == 20:
                        face.ask("decide", cycle=4)
                    time.sleep(0.05)
                done.set()

            threading.Thread(target=move).start()
            with pytest.raises(TimeoutError):
                xsens_reader.follow(listening)
            assert done.wait(5)

    face.ask("observe", cycle=4, observation="arm")
    plc = Plc()
    with pytest.raises(ConnectionError):
        asyncio.run(plc_gateway.follow(plc))
    assert ("cycle", 5) in plc.written

    events = [one.event for one in read_journal(server.journal)]
    observed = {event.cycle: event for event in events if isinstance(event, Observed)}
    assert (observed[2].executed, observed[2].observation) == ("low", "arm")
    assert observed[3].late
    assert observed[3].likelihood == pytest.approx({"back": 0.95, "arm": 0.05})
    assert (observed[5].executed, observed[5].observation) == ("low", "back")
    assert [event.cycle for event in events if isinstance(event, Skipped)] == [6]

"""The client of Lab Streaming Layer, on loopback, with a real server: streams that come, go, err, and are late."""

import json
import math
import signal
import subprocess
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pylsl
import pytest
from commands import process
from conftest import PAPER
from pylsl.util import LostError
from pylsl.util import TimeoutError as LslTimeoutError

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.live.clients.client import Client
from fatigue_planner.live.clients.connection import Address, Connection
from fatigue_planner.live.clients.lsl import LslClient
from fatigue_planner.live.events import Observed
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.rehearsal.server import Server

WAIT_S = 30.0
EARLY_S = 0.3


@pytest.fixture(scope="module")
def server(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    options = [str(PAPER), "--condition", "multiple_novice", "--cache", str(cache_folder)]
    with Server(tmp_path_factory.mktemp("lsl") / "shift.fatplan", options, rehearsal=False) as running:
        yield running


@dataclass
class Cell:
    """The server's shift, a robot that the test plays, and the client; `seen` is the recogniser's stream."""

    server: Server
    robot: Connection
    client: "subprocess.Popen[str]"
    name: str

    def cycle(self) -> int:
        return int(self.robot.state()["cycle"])

    def observed(self) -> dict[int, Observed]:
        events = [one.event for one in read_journal(self.server.journal)]
        return {event.cycle: event for event in events if isinstance(event, Observed)}

    def recorded(self, cycle: int, late: bool = False) -> Observed:
        """How a cycle was observed, as soon as that is on the disk."""
        until(lambda: cycle in self.observed() and self.observed()[cycle].late == late)
        return self.observed()[cycle]

    def end(self) -> str:
        """What the client has said."""
        self.client.send_signal(signal.SIGINT)
        assert self.client.wait(WAIT_S) == 130
        assert self.client.stderr is not None
        return self.client.stderr.read()


@pytest.fixture
def cell(server: Server, request: pytest.FixtureRequest) -> Iterator[Cell]:
    robot, name = Connection(server.address), request.node.name
    robot.decide()
    words = ("live", "lsl", name, "--server", server.address.url, "--early", EARLY_S, "--out", f"{name} out")
    with closing(robot), process(*words, "--token-file", server.address.token_file) as client:
        yield Cell(server, robot, client, name)
        client.kill()


def stream(name: str, labels: tuple[str, ...] = ()) -> pylsl.StreamOutlet:
    """A recogniser's stream, of texts or of numbers with these labels, to which the client has come."""
    form = pylsl.cf_double64 if labels else pylsl.cf_string
    info = pylsl.StreamInfo(name, "Reactions", len(labels) or 1, pylsl.IRREGULAR_RATE, form, f"test {time.time()}")
    channels = info.desc().append_child("channels")
    for label in labels:
        channels.append_child("channel").append_child_value("label", label)
    outlet = pylsl.StreamOutlet(info)
    assert outlet.wait_for_consumers(WAIT_S)
    time.sleep(2 * EARLY_S)  # and the cycle has gone on for some time
    return outlet


def until(what: Callable[[], bool]) -> None:
    """Wait for something, but not for ever."""
    end = time.monotonic() + WAIT_S
    while not what():
        assert time.monotonic() < end
        time.sleep(0.05)


def marker(inlet: pylsl.StreamInlet) -> Any:
    """The next decision."""
    values, _ = inlet.pull_sample(WAIT_S)
    assert values
    return json.loads(values[0])


@pytest.mark.slow
def test_reactions_come_in_and_decisions_go_out(cell: Cell) -> None:
    """One that comes, is late, says a thing twice or otherwise, vanishes and comes again."""
    found = pylsl.resolve_byprop("name", f"{cell.name} out", 1, WAIT_S)
    decisions = pylsl.StreamInlet(found[0])
    decisions.open_stream(WAIT_S)
    first = cell.cycle()
    seen = stream(cell.name)
    seen.push_sample(["arm"])
    until(lambda: cell.cycle() == first + 1)
    assert cell.recorded(first).observation == "arm"
    told = marker(decisions)
    if told["cycle"] == first:  # the stream was listened to before this cycle's was sent
        told = marker(decisions)
    assert told == {"cycle": first + 1, "action": cell.robot.decide().action}
    # the robot has gone on; what is stamped in the cycle before is of that
    time.sleep(2 * EARLY_S)
    stamp_s = pylsl.local_clock()
    cell.robot.decide(first + 2)
    assert marker(decisions)["cycle"] == first + 2
    seen.push_sample(["back"], stamp_s)
    assert cell.recorded(first + 1, late=True).observation == "back"
    assert cell.cycle() == first + 2
    seen.push_sample(["back"], stamp_s)
    seen.push_sample(["arm"], stamp_s + 0.001)
    until(lambda: cell.robot.state()["counts"]["contradicted"] == 1)
    del seen
    time.sleep(0.5)
    again = stream(cell.name)
    again.push_sample(["arm"])
    until(lambda: cell.cycle() == first + 3)
    decisions.close_stream()
    said = cell.end()
    assert f"the stream {cell.name} has ended" in said
    assert "was observed otherwise before" in said
    assert "Traceback" not in said


@pytest.mark.slow
def test_likelihoods_and_absurd_numbers(cell: Cell) -> None:
    """Ratios count, at any scale; what is no likelihood, or of no time, changes nothing."""
    first = cell.cycle()
    seen = stream(cell.name, ("back", "arm"))
    before = cell.robot.state()["recorded"]
    for wrong in ([math.nan, 1.0], [math.inf, 1.0], [-0.1, 1.0], [0.0, 0.0]):
        seen.push_sample(wrong)
    seen.push_sample([0.5, 0.5], pylsl.local_clock() + 1000)
    seen.push_sample([0.5, 0.5], pylsl.local_clock() - 1e6)
    time.sleep(1)
    assert cell.robot.state()["recorded"] == before
    seen.push_sample([1e308, 4e307])
    until(lambda: cell.cycle() == first + 1)
    likelihood = cell.recorded(first).likelihood
    assert likelihood == pytest.approx({"back": 1.0, "arm": 0.4})
    said = cell.end()
    assert "which is no observation" in said
    assert "the stream's time stamp is of no cycle that can be told" in said
    assert "Traceback" not in said


def test_a_clock_that_does_not_answer_ends_no_stream() -> None:
    """The sample waits until the clocks can be compared; a stream that is lost has ended."""
    said: list[str] = []
    client = LslClient.__new__(LslClient)
    Client.__init__(client, Address("http://127.0.0.1:1", Path("none")), said.append)
    client._name, client._early_s, client._last_s = "arms", 0.0, -math.inf
    client._labels, client._reactions = (), ("arm",)
    client._began_s = OrderedDict({1: pylsl.local_clock() - 100})
    told: list[dict[str, Any]] = []
    client.tell = lambda name, **what: told.append({"name": name} | what)  # type: ignore[method-assign,assignment]
    client._resolver = SimpleNamespace(results=list)

    class Inlet:
        """Its clock does not answer at first, and in the end it is lost."""

        looks = 0

        def time_correction(self, timeout: float) -> float:
            self.looks += 1
            if self.looks == 1:
                raise LslTimeoutError
            if self.looks == 3:
                raise LostError
            return 0.0

        def pull_sample(self, timeout: float) -> tuple[list[str], float]:
            return ["arm"], pylsl.local_clock() - 50

    client._inlet = Inlet()
    client.look(1, "low")
    assert client._inlet is not None and told == []
    client.look(1, "low")
    assert told == [{"name": "observe", "cycle": 1, "observation": "arm"}]
    assert client._inlet is None
    assert [("does not answer" in one, "has ended" in one) for one in said] == [(True, False), (False, True)]


@pytest.mark.parametrize(
    ("labels", "refused"), [(("back", "leg", "arm"), False), (("arm or back", "leg"), True), (("arm", "leg"), True)]
)
def test_likelihoods_are_of_preferences(
    monkeypatch: pytest.MonkeyPatch, labels: tuple[str, ...], refused: bool
) -> None:
    """Two that cannot be told apart are one observation; how likely each of them was can be said all the same."""
    info = pylsl.StreamInfo("arms", "Reactions", len(labels), pylsl.IRREGULAR_RATE, pylsl.cf_double64, "test")
    channels = info.desc().append_child("channels")
    for label in labels:
        channels.append_child("channel").append_child_value("label", label)
    client = LslClient.__new__(LslClient)
    Client.__init__(client, Address("http://127.0.0.1:1", Path("none")), lambda _: None)
    client.state = {"preferences": ["arm", "back", "leg"]}
    client.check(("low",), ("arm or back", "leg"))
    client._name, client._inlet, client._resolver = "arms", None, SimpleNamespace(results=lambda: [info])
    opened = SimpleNamespace(info=lambda _: info, open_stream=lambda _: None)
    monkeypatch.setattr(pylsl, "StreamInlet", lambda *_, **__: opened)
    if refused:
        with pytest.raises(SelectionError, match="a number per preference: arm, back, leg"):
            client._open()
    else:
        client._open()
        assert client._inlet is opened
        assert client._meaning([0.5, 0.0, 0.25]) == {"likelihood": {"back": 0.5, "leg": 0.0, "arm": 0.25}}


@pytest.mark.slow
def test_other_channels_are_refused(cell: Cell) -> None:
    wrong = pylsl.StreamOutlet(pylsl.StreamInfo(cell.name, "Reactions", 2, pylsl.IRREGULAR_RATE, pylsl.cf_float32, "x"))
    assert cell.client.wait(WAIT_S) == 2
    assert cell.client.stderr is not None
    assert "its channels are not labelled; should be one text, or a number per preference: arm, back" in (
        cell.client.stderr.read()
    )
    del wrong

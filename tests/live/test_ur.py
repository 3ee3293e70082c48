"""The client of a UR robot, against a stand-in of its controller and a real server: only an echo is delivery."""

import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pytest
from commands import process
from conftest import PAPER
from rtde_controller import ControllerProcess

from fatigue_planner.live.clients.connection import Answer, Connection
from fatigue_planner.live.events import Executed, Observed
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.rehearsal.server import Server

pytest.importorskip("rtde_receive", reason="there is no wheel of ur-rtde for this Python")
ROBOT = "127.0.30.4"
WAIT_S = 30.0
ASKED = "output_int_register_38"
NUMBERS = {"high": 1, "low": 2}


@pytest.fixture(scope="module")
def server(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    options = [str(PAPER), "--condition", "multiple_novice", "--cache", str(cache_folder)]
    with Server(tmp_path_factory.mktemp("ur") / "shift.fatplan", options, rehearsal=False) as running:
        yield running


@dataclass
class Cell:
    """The server's shift, a tracker that the test plays, the robot's controller and its client."""

    server: Server
    tracker: Connection
    controller: ControllerProcess
    client: "subprocess.Popen[str]"

    def cycle(self) -> int:
        return int(self.tracker.state()["cycle"])

    def robot(self) -> str:
        return str(self.tracker.state()["robot"])

    def asked(self) -> tuple[int, int]:
        registers = self.controller.ask()
        return registers.get("input_int_register_42", 0), registers.get("input_int_register_43", 0)

    def told(self) -> list[tuple[int, str | None]]:
        events = [one.event for one in read_journal(self.server.journal)]
        return [(one.cycle, one.action) for one in events if isinstance(one, Executed)]

    def observe(self, seen: str) -> Answer:
        answer = self.tracker.call("observe", cycle=self.cycle(), observation=seen)
        assert answer is not None
        return answer

    def end(self) -> str:
        """What the client has said."""
        self.client.send_signal(signal.SIGINT)
        assert self.client.wait(WAIT_S) == 130
        assert self.client.stderr is not None
        return self.client.stderr.read()


@pytest.fixture
def cell(server: Server) -> Iterator[Cell]:
    tracker = Connection(server.address)
    tracker.decide()
    words = ("live", "ur", ROBOT, "--poses", "high,low", "--server", server.address.url, "--grace", 0.2)
    with (
        closing(tracker),
        ControllerProcess(ROBOT) as controller,
        process(*words, "--token-file", server.address.token_file) as client,
    ):
        yield Cell(server, tracker, controller, client)
        client.kill()


def until(what: Callable[[], bool]) -> None:
    """Wait for something, but not for ever."""
    end = time.monotonic() + WAIT_S
    while not what():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.mark.slow
def test_what_the_robot_says_it_does_is_told(cell: Cell) -> None:
    """What it executes counts, also if it is something else; absurd numbers do not; it asks where the tracker fails."""
    cycle, first = cell.cycle(), cell.tracker.decide()
    until(lambda: cell.asked() == (NUMBERS[first.action], cycle) and cell.robot() == "answers")
    cell.controller.ask("other")
    second = cell.observe("arm")
    other = "low" if second.action == "high" else "high"
    until(lambda: (cycle + 1, other) in cell.told())
    cell.controller.ask("set", ASKED, cycle + 2)
    until(lambda: cell.cycle() == cycle + 2)
    cell.controller.ask("absurd")
    time.sleep(0.5)
    said = cell.end()
    assert "the robot says pose -7 of cycle 2147483647, which cannot be" in said
    assert "Traceback" not in said
    events = [one.event for one in read_journal(cell.server.journal)]
    observed = {event.cycle: event for event in events if isinstance(event, Observed)}
    assert (observed[cycle + 1].executed, observed[cycle + 1].observation) == (other, None)
    assert all(number <= cycle + 2 for number, _ in cell.told())


@pytest.mark.slow
def test_scenario_28_only_an_echo_is_delivery(cell: Cell) -> None:
    """Silent for a cycle, late, off while we write, on again, a cable pulled, the server killed."""
    until(lambda: cell.robot() == "answers")
    cell.controller.ask("silent")
    cell.observe("arm")
    cell.observe("arm")
    until(lambda: cell.robot() == "unreachable")
    cell.controller.ask("echo")
    until(lambda: cell.robot() == "answers")
    cell.controller.ask("stop")
    cell.observe("arm")
    until(lambda: cell.robot() == "unreachable")
    cell.controller.ask("start")
    until(lambda: cell.asked()[1] == cell.cycle() and cell.robot() == "answers")
    cell.controller.ask("freeze")
    until(lambda: cell.robot() == "unreachable")
    cell.controller.ask("thaw")
    until(lambda: cell.robot() == "answers")
    cell.server.kill()
    cell.server.restart()
    after = cell.observe("back")
    until(lambda: cell.asked() == (NUMBERS[after.action], after.cycle) and (after.cycle, after.action) in cell.told())
    assert cell.client.poll() is None
    said = cell.end()
    assert "robot unreachable: it does not say what it does" in said
    assert "Traceback" not in said


@pytest.mark.slow
def test_other_poses_are_refused(server: Server) -> None:
    done = process(
        "live", "ur", "127.0.30.5", "--poses", "high,middle", "--server", server.address.url,
        "--token-file", server.address.token_file,
    )  # fmt: skip
    _, said = done.communicate(timeout=60)
    assert done.returncode == 2
    assert "poses high, middle: should name every action of the experiment once" in said

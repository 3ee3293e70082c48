"""What comes from outside: clients vanish, the server is killed, workers swap, there is a pause."""

import json
import socket
from urllib.parse import urlsplit

from fatigue_planner.live.events import Rested, WorkerChanged
from fatigue_planner.live.rehearsal.cell import PSEUDONYMS, Cell
from fatigue_planner.live.rehearsal.fault import Fault, Reaction

MOMENTS = ("before the decision", "after the decision", "after the pose", "while the tracker speaks", "after the cycle")


class ClientVanishes(Fault):
    """The tracker's connection ends within a request, or before it has read the answer; then it says it again."""

    name, rate = "client_vanishes", 0.02

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        pose = cell.present()
        seen = cell.work(pose)
        half = bool(cell.rng.integers(2))
        before = cell.state()
        request(cell, seen, half)
        taken = cell.state()["cycle"] == cell.cycle + 1
        answer = cell.tell(cell.cycle, seen)
        cell.end(pose, seen)
        right = answer.cycle == cell.cycle and not (half and taken) and before["cycle"] == cell.cycle - 1
        return Reaction("half a request is none" if half else "taken once", right)


class ServerKilled(Fault):
    """SIGKILL at some moment of a cycle; it starts again after an outage, and is told again what may be lost."""

    name, rate = "server_killed", 0.004

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        moment = MOMENTS[cell.rng.integers(len(MOMENTS))]
        decided, seen, pose = None, None, ""
        cell.settle()  # in real time, all but what was said last has long been on the disk
        if moment != MOMENTS[0]:
            decided = cell.robot.decide(cell.cycle)
        if moment in MOMENTS[2:]:
            pose = cell.present()
            seen = cell.work(pose)
        if moment == MOMENTS[3]:
            cell.settle()
            request(cell, seen or "", half=False)
        elif moment == MOMENTS[4]:
            cell.settle()
            decided = cell.tell(cell.cycle, seen or "")
            cell.end(pose, seen)
        cell.server.kill()
        cell.server.restart()
        cell.operator.call("clock", seconds=cell.now_s)
        for client in (cell.tracker, cell.robot):  # they find a new token, and say again what may be lost
            client.state()
        again = cell.robot.decide()
        right = decided is None or again.cycle != decided.cycle or again.action == decided.action
        if seen is not None and moment != MOMENTS[4]:
            cell.tell(cell.cycle, seen)
            cell.end(pose, seen)
        cell.pass_time(float(cell.rng.integers(5, 120)))  # nobody works until all is in order
        cell.ordinary()
        return Reaction(f"went on, killed {moment}", right)


class WorkerSwaps(Fault):
    """Another worker comes; one who was here before has rested."""

    name, rate = "worker_swaps", 0.004

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        others = [one for one in PSEUDONYMS if one != cell.worker.pseudonym]
        swap(cell, str(cell.rng.choice(others)))
        right = cell.state()["advised"]
        cell.ordinary()
        return Reaction("another belief", right)  # whose, the journal shows


class Pause(Fault):
    """The operator says that there was a pause."""

    name, rate = "pause", 0.01

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        seconds = round(float(cell.rng.uniform(20, 900)), 1)
        cell.pass_time(seconds)
        answer = cell.operator.call("rest", seconds=seconds)
        cell.worker.rest(cell.now_s - cell.ended_s)
        cell.ended_s = cell.now_s
        cell.expect(Rested(seconds=seconds))
        right = answer is not None and answer.cycle == cell.cycle
        cell.ordinary()
        return Reaction("the worker rested", right)


def swap(cell: Cell, pseudonym: str) -> None:
    """Let another worker come."""
    if pseudonym != cell.worker.pseudonym:  # not the first one's coming
        cell.left_s[cell.worker.pseudonym] = cell.now_s
    cell.worker = cell.person(pseudonym)
    cell.operator.call("worker", pseudonym=pseudonym)
    left_s = cell.left_s.get(pseudonym)
    away_s = None if left_s is None else cell.now_s - left_s
    cell.worker.rest(away_s or 0.0)
    cell.expect(WorkerChanged(worker=pseudonym, away_s=away_s))
    cell.ended_s = cell.now_s


def request(cell: Cell, seen: str, half: bool) -> None:
    """What the tracker has to say, on a connection that ends before an answer is read."""
    body = json.dumps({"cycle": cell.cycle, "observation": seen}).encode()
    address = cell.server.address
    parts = urlsplit(address.url)
    lines = [f"POST /v1/observe HTTP/1.1\r\nHost: {parts.netloc}", f"Authorization: Bearer {address.token()}"]
    head = "\r\n".join([*lines, f"Content-Length: {len(body)}", "", ""]).encode()
    with socket.create_connection((str(parts.hostname), parts.port or 0)) as sending:
        sending.sendall(head + (body[: len(body) // 2] if half else body))

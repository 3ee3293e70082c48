"""The cell of a rehearsal: robot, tracker and operator, each a client of the server, and the time that they share."""

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fatigue_planner.live.clients.connection import Answer, Connection
from fatigue_planner.live.events import Input, Observed, Skipped
from fatigue_planner.live.rehearsal.people import SimulatedWorker
from fatigue_planner.live.rehearsal.server import Server
from fatigue_planner.live.standing import MIN_IDLE_S
from fatigue_planner.pomdp.scenario import Scenario

SETTLE_WAIT_S = 10.0
PSEUDONYMS = ("w-rehearsal-1", "w-rehearsal-2", "w-rehearsal-3")


@dataclass(frozen=True)
class Expected:
    """An input that the journal must hold, and the fault in whose course it was said; "" for none."""

    event: Input
    fault: str


@dataclass
class Cell:
    """Who works, where and since when. Only `inputs` and `workers` know what is right; the server is not asked.

    cycle: the one going on; now_s: what the clock shows; ended_s: when the last cycle or pause ended; speed: how many
    times faster than real time, 0: as fast as it goes.
    """

    server: Server
    scenario: Scenario
    seed: int
    rng: np.random.Generator
    speed: float = 0.0
    cycle: int = 1
    now_s: float = 0.0
    ended_s: float = 0.0
    fault: str = ""
    inputs: list[Expected] = field(default_factory=list)
    workers: dict[str, SimulatedWorker] = field(default_factory=dict)
    left_s: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        address = self.server.address
        self.robot, self.tracker, self.operator = (Connection(address) for _ in range(3))
        self.worker = self.person(PSEUDONYMS[0])

    @property
    def cycle_s(self) -> float:
        """The planned duration of a cycle."""
        assert self.scenario.model.timing is not None
        return self.scenario.model.timing.cycle_s

    def person(self, pseudonym: str) -> SimulatedWorker:
        """A worker, who remembers how tired he is."""
        if pseudonym not in self.workers:
            self.workers[pseudonym] = SimulatedWorker(self.scenario, self.seed, pseudonym)
        return self.workers[pseudonym]

    def state(self) -> dict[str, Any]:
        """Where the shift stands, as the operator sees it."""
        return self.operator.state()

    def pass_time(self, seconds: float) -> None:
        """Let time pass, for the server too."""
        if self.speed:
            time.sleep(seconds / self.speed)
        self.now_s += seconds
        self.operator.call("clock", seconds=self.now_s)

    def present(self, pose: str | None = None) -> str:
        """The robot asks what to do, does that or another pose, and says which."""
        asked = self.robot.decide(self.cycle)
        done = asked.action if pose is None else pose
        self.robot.call("executed", cycle=self.cycle, action=done)
        return done

    def work(self, pose: str) -> str:
        """The worker works for a cycle; as what the tracker recognises it."""
        self.worker.rest(self._idle_s())
        seen = self.worker.work(pose)
        self.pass_time(self.cycle_s)
        return seen

    def end(self, pose: str, seen: str | None) -> Observed:
        """A cycle has ended so: from now on the next goes on."""
        event = Observed(
            cycle=self.cycle, executed=pose, observation=seen, idle_s=self._idle_s(self.now_s - self.cycle_s)
        )
        self.expect(event)
        self.cycle, self.ended_s = self.cycle + 1, self.now_s
        return event

    def skip(self) -> None:
        """A cycle has ended in which nothing was done."""
        self.expect(Skipped(cycle=self.cycle, duration_s=self.cycle_s))
        self.cycle, self.ended_s = self.cycle + 1, self.now_s

    def tell(self, cycle: int, seen: str) -> Answer:
        """The tracker says what it recognised."""
        answer = self.tracker.call("observe", cycle=cycle, observation=seen)
        assert answer is not None
        return answer

    def ordinary(self) -> None:
        """A cycle without a fault."""
        pose = self.present()
        seen = self.work(pose)
        self.tell(self.cycle, seen)
        self.end(pose, seen)

    def expect(self, event: Input) -> None:
        """The journal must hold this next."""
        self.inputs.append(Expected(event, self.fault))

    def settle(self) -> None:
        """Wait until all that was said is on the disk."""
        until = time.monotonic() + SETTLE_WAIT_S
        while (state := self.state())["durable_up_to"] < state["recorded"] and time.monotonic() < until:
            time.sleep(0.01)

    def close(self) -> None:
        """Close the connections."""
        for connection in (self.robot, self.tracker, self.operator):
            connection.close()

    def _idle_s(self, until_s: float | None = None) -> float:
        idle_s = (self.now_s if until_s is None else until_s) - self.ended_s
        return 0.0 if idle_s < MIN_IDLE_S else idle_s

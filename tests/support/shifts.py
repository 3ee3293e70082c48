"""Shifts of the paper's task that pass as fast as they can be computed: a clock that is moved, and cycles worked."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import commands
from planting import Planted, program
from servers import Server, start

import fatigue_planner as fp
from fatigue_planner.live.events import Event
from fatigue_planner.live.journal_file import read_journal
from fatigue_planner.live.shift import Shift

CYCLE_S = 16.0


class FakeClock(fp.Clock):
    """A clock that stands until it is moved."""

    def __init__(self, boot: str = "boot 1") -> None:
        self.now_s, self.boot, self.slept = 1000.0, boot, 0.0
        self.wall = datetime(2026, 11, 28, 6, 0, tzinfo=UTC)

    def pass_(self, seconds: float) -> None:
        self.now_s += seconds
        self.wall += timedelta(seconds=seconds)

    def seconds(self) -> float:
        return self.now_s

    def utc(self) -> datetime:
        return self.wall

    def origin(self) -> str:
        return self.boot

    def slept_s(self) -> float:
        return self.slept


def standing(session: fp.Session) -> Shift:
    """Where a session stands after its last answer, which it may have given before it went on."""
    session.digest()
    return session._shift


def cycles(session: fp.Session, clock: FakeClock, seen: Sequence[str | None]) -> list[str]:
    """Work a cycle for each of what is seen; the actions."""
    done = []
    for one in seen:
        decision = session.decide()
        done.append(decision.action)
        clock.pass_(CYCLE_S)
        session.observe(decision.cycle, observation=one)
    return done


@dataclass
class World:
    """Where a scenario happens: a folder, the paper's task, a clock; and the fault that servers there have."""

    folder: Path
    scenario: fp.Scenario
    cache: Path
    fault: Planted | None = None
    clock: FakeClock = field(default_factory=FakeClock)

    @property
    def path(self) -> Path:
        return self.folder / "shift.fatplan"

    def open(self, name: str = "shift.fatplan", clock: FakeClock | None = None, **options: Any) -> fp.Session:
        return fp.Session.open(self.folder / name, self.scenario, clock=clock or self.clock, **options)

    @contextmanager
    def serving(self, *options: object) -> Iterator[Server]:
        """A server, which is ended in good order; killed if something fails."""
        server = self._started(*options)
        try:
            yield server
            server.process.terminate()
            server.process.wait(60)
        finally:
            server.process.kill()
            server.process.communicate()

    def _started(self, *options: object) -> Server:
        before = commands.FATPLAN[:]
        if self.fault:
            commands.FATPLAN[2] = program(self.fault) + commands.FATPLAN[2]
        try:
            return start(self.path, self.cache, *options)
        finally:
            commands.FATPLAN[:] = before

    def events(self, kind: type[Event] | None = None, name: str = "shift.fatplan") -> list[Any]:
        """What the journal has of a kind."""
        stored = read_journal(self.folder / name)
        return [one.event for one in stored if kind is None or isinstance(one.event, kind)]

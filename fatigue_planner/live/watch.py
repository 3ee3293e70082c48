"""What a session watches for the worker: alarms with hysteresis, what is coming, and load doses.

Nothing of this decides anything. It is done after the decisions have been prepared, never between a question and its
answer.
"""

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

from fatigue_planner.core.random_streams import Vector, random_stream
from fatigue_planner.live.doses import Doses, LivedCycle, RecentDoses, reaction_chances
from fatigue_planner.live.events import (
    Acknowledged,
    Advice,
    Alarmed,
    AlarmSettings,
    Cleared,
    Event,
    Observed,
    Rested,
    Skipped,
    WorkerChanged,
)
from fatigue_planner.live.pauses import CLEARED, RAISED, JointLevel, Levels, Passing, half_life_s, levels, passings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

# A belief is kept for every cycle that is not metered yet.
MAX_UNMETERED = 64


@dataclass(frozen=True)
class Alarm(JointLevel):
    """An entry that was above the limit and is not clearly below it yet. since_cycle: when it was first told."""

    since_cycle: int
    acknowledged: bool


class Alarms:
    """The alarms of the worker who is here. One is told once, and again some time after it was acknowledged."""

    def __init__(self, settings: AlarmSettings) -> None:
        self.settings = settings
        self._raised: dict[str, Alarm] = {}
        self._seen_s: dict[str, float] = {}

    def account(self, event: Event, at_s: float) -> None:
        """Stand where an event of this moment leads."""
        match event:
            case Alarmed():
                since = self._raised[event.entry].since_cycle if event.entry in self._raised else event.cycle
                alarm = Alarm(event.entry, event.probability, event.pause_s, since, acknowledged=False)
                self._raised[event.entry] = alarm
            case Acknowledged():
                for entry in self._raised.keys() & set(event.entries):
                    self._raised[entry] = replace(self._raised[entry], acknowledged=True)
                    self._seen_s[entry] = at_s
            case Cleared():
                self._raised.pop(event.entry, None)
            case WorkerChanged() | Advice(on=False):
                self._raised.clear()

    def due(self, levels: tuple[JointLevel, ...], cycle: int, at_s: float) -> list[Alarmed | Cleared]:
        """What has to be told where entries stand so; those that are not named are below the limit."""
        found: list[Alarmed | Cleared] = []
        above = {level.entry: level for level in levels if level.probability > CLEARED}
        for entry, level in above.items():
            raised = self._raised.get(entry)
            repeated = raised is not None and self._is_forgotten(raised, at_s)
            if raised is not None:
                self._raised[entry] = replace(raised, probability=level.probability, pause_s=level.pause_s)
            if repeated or (raised is None and level.probability >= RAISED):
                told = {"cycle": cycle, "entry": entry, "probability": level.probability, "pause_s": level.pause_s}
                found.append(Alarmed.model_validate(told | {"repeated": repeated}))
        return found + [Cleared(cycle=cycle, entry=entry) for entry in self._raised if entry not in above]

    def now(self) -> tuple[Alarm, ...]:
        """The alarms that are on, that with the longest pause first."""
        return tuple(sorted(self._raised.values(), key=lambda one: -math.inf if one.pause_s is None else -one.pause_s))

    def _is_forgotten(self, alarm: Alarm, at_s: float) -> bool:
        """Whether it was acknowledged so long ago that it has to be told again."""
        return alarm.acknowledged and at_s - self._seen_s[alarm.entry] >= self.settings.repeat_s


class Watch:
    """The alarms, what is coming and the doses of a session. `look` may be called from any thread."""

    def __init__(self, model: FatiguePomdp, settings: AlarmSettings, likelihood: Callable[[Observed], Vector]) -> None:
        """likelihood: of what was seen of a cycle, under every reaction."""
        self._likelihood = likelihood
        self.alarms = Alarms(settings)
        self.half_life_s = half_life_s(model)
        self.fault = ""
        self._model = model
        self._looking = threading.Lock()
        self._looked: Belief | None = None
        self._levels = Levels((), ())
        self._lived: deque[_Lived] = deque()
        self._recent: dict[str, RecentDoses] = {}
        self._coming: tuple[int, tuple[Passing, ...]] = (0, ())

    def account(self, event: Event, at_s: float, worker: str = "", before: Belief | None = None) -> None:
        """Note what has happened; a cycle's worker, and the belief before it if it is to be metered (later)."""
        match event:
            case Observed():
                if before is not None:
                    self._lived.append(_Lived(event, at_s, worker, before))
                    if len(self._lived) > MAX_UNMETERED:
                        self._meter()
                return
            case Advice(on=False):
                self._coming = 0, ()
                with self._looking:
                    self._lived = deque(one for one in self._lived if one.worker != worker)
                    self._recent.pop(worker, None)
            case WorkerChanged() | Rested() | Skipped():
                self._coming = 0, ()
        self.alarms.account(event, at_s)

    def look(self, belief: Belief) -> Levels:
        """How the belief stands; and meter what has been lived since the last look."""
        self._meter()
        with self._looking:
            if belief is not self._looked:
                self._levels, self._looked = levels(belief, self.alarms.settings.limit), belief
            return self._levels

    def foresee(self, belief: Belief, cycle: int, plan: Callable[[Belief, int], int]) -> None:
        """Find out what will pass the limit, from this cycle on; `plan` as in `pauses.passings`."""
        rng = random_stream(0, "live watch", cycle)
        self._coming = cycle, passings(belief, self.alarms.settings.limit, plan, rng)

    def coming(self, cycle: int) -> tuple[Passing, ...]:
        """What will pass the limit, counted from this cycle, as it was last foreseen."""
        foreseen, found = self._coming
        counted = (replace(one, in_cycles=one.in_cycles - (cycle - foreseen)) for one in found)
        return tuple(one for one in counted if one.in_cycles > 0)

    def last_hour(self, worker: str, now_s: float) -> Doses:
        """The doses of a worker's last hour."""
        with self._looking:
            return self._recent.get(worker, RecentDoses()).last_hour(self._model, now_s)

    def _meter(self) -> None:
        with self._looking:
            while self._lived:
                lived = self._lived.popleft()
                event, before = lived.event, lived.before
                if event.idle_s:
                    before = before.rest(event.idle_s)
                action = self._model.actions.index(event.executed)
                chances = reaction_chances(before, action, self._likelihood(event))
                cycle = LivedCycle(lived.at_s, action, chances, event.duration_s)
                self._recent.setdefault(lived.worker, RecentDoses()).add(event.cycle, cycle)


class _Lived(NamedTuple):
    """A cycle that was lived and not metered yet."""

    event: Observed
    at_s: float
    worker: str
    before: Belief

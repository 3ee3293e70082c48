"""What a journal says of a shift when it is over: cycles and pauses by worker, with times; no session is needed.

What was told late stands in its place. Times are those that passed by the clock that is never set back; where the
machine started anew, the time of day says how long that took. The time of day is that of the last event: a clock that
was set in mid-shift was set right.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from itertools import pairwise
from typing import Literal

from fatigue_planner.live.events import (
    Advice,
    Closed,
    Decided,
    Event,
    Input,
    Observed,
    Opened,
    Rested,
    Resumed,
    Skipped,
    WorkerChanged,
)
from fatigue_planner.live.journal_file import Stored

PauseKind = Literal["said", "clock", "away"]


@dataclass(frozen=True)
class Worked:
    """A cycle that has ended: whose, when in s since the journal began, how, and what had been decided, if it was."""

    cycle: int
    worker: str
    ended_s: float
    end: Observed | Skipped
    decided: Decided | None
    told_late: bool


@dataclass(frozen=True)
class Pause:
    """A rest of a worker, before `ended_s`: said, or between two cycles by the clock, or while others worked."""

    worker: str
    ended_s: float
    seconds: float
    kind: PauseKind


@dataclass(frozen=True)
class Step:
    """An input in its place, and when it was said, in s since the journal began."""

    at_s: float
    event: Input


@dataclass(frozen=True)
class Aside:
    """What is neither an input nor a decision, when, and who worked."""

    at_s: float
    worker: str
    event: Event


@dataclass(frozen=True)
class Segment:
    """What belongs to one opening: inputs in order, what was decided, and everything else.

    began_s: when, in s since the journal began.
    """

    opened: Opened
    began_s: float
    steps: list[Step] = field(default_factory=list)
    decided: list[Decided] = field(default_factory=list)
    asides: list[Aside] = field(default_factory=list)
    late: set[int] = field(default_factory=set)

    def by_worker(self) -> Iterator[tuple[str, Step]]:
        """Every input with whose it is; another worker's coming is his own."""
        worker = ""
        for step in self.steps:
            worker = step.event.worker if isinstance(step.event, WorkerChanged) else worker
            yield worker, step

    def worked(self) -> list[Worked]:
        """The cycles, in order."""
        decided = {one.cycle: one for one in self.decided}
        return [
            Worked(
                step.event.cycle, worker, step.at_s, step.event, decided.get(step.event.cycle),
                step.event.cycle in self.late,
            )
            for worker, step in self.by_worker()
            if isinstance(step.event, Observed | Skipped)
        ]  # fmt: skip

    def pauses(self, planned_s: float) -> list[Pause]:
        """The rests, in order, of whatever kind; a cycle took as long as planned where nothing else was said."""
        found = []
        for worker, step in self.by_worker():
            match step.event:
                case Rested(seconds=seconds) if seconds > 0:
                    found.append(Pause(worker, step.at_s, seconds, "said"))
                case Observed(idle_s=seconds, duration_s=took_s) if seconds > 0:
                    found.append(Pause(worker, step.at_s - (planned_s if took_s is None else took_s), seconds, "clock"))
                case WorkerChanged(away_s=float(seconds)) if seconds > 0:
                    found.append(Pause(worker, step.at_s, seconds, "away"))
        return found

    def switches(self) -> list[tuple[float, str, bool]]:
        """When which worker switched the belief about him off or on."""
        return [
            (step.at_s, worker, step.event.on) for worker, step in self.by_worker() if isinstance(step.event, Advice)
        ]


@dataclass(frozen=True)
class Record:
    """A journal: its segments, the time of day at its beginning, and how long it goes on."""

    segments: tuple[Segment, ...]
    began: datetime
    lasted_s: float
    is_closed: bool

    @property
    def workers(self) -> list[str]:
        """The random numbers of those who worked, in the order in which they came; "": who was not named."""
        return list(dict.fromkeys(one.worker for segment in self.segments for one in segment.worked()))

    def local(self, at_s: float) -> datetime:
        """The local time of a moment."""
        return (self.began + timedelta(seconds=at_s)).astimezone()


def record_of(events: Sequence[Stored]) -> Record | None:
    """What the events of a journal say; None of an empty one."""
    if not events:
        return None
    at_s = _times(events)
    segments: list[Segment] = []
    worker = ""
    for stored, when_s in zip(events, at_s, strict=True):
        event = stored.event
        if isinstance(event, Opened):
            segments.append(Segment(event, when_s))
            worker = ""
            continue
        segment = segments[-1]
        if isinstance(event, Observed) and event.late:
            _tell_late(segment, event)
        elif isinstance(event, Input):
            segment.steps.append(Step(when_s, event))
            worker = event.worker if isinstance(event, WorkerChanged) else worker
        elif isinstance(event, Decided):
            segment.decided.append(event)
        else:
            segment.asides.append(Aside(when_s, worker, event))
    last = datetime.fromisoformat(events[-1].utc)
    began = last - timedelta(seconds=at_s[-1])
    return Record(tuple(segments), began, at_s[-1], isinstance(events[-1].event, Closed))


def _tell_late(segment: Segment, event: Observed) -> None:
    """Put what was told late of a cycle in its place."""
    for number in range(len(segment.steps) - 1, -1, -1):
        step = segment.steps[number]
        if isinstance(step.event, Observed) and step.event.cycle == event.cycle:
            segment.steps[number] = Step(step.at_s, event.model_copy(update={"late": False}))
            segment.late.add(event.cycle)
            return


def _times(events: Sequence[Stored]) -> list[float]:
    """When every event was, in s since the first."""
    at_s, origin = [0.0], _origin(events[0].event)
    for before, after in pairwise(events):
        now = _origin(after.event) or origin
        if now == origin:
            passed_s = after.seconds - before.seconds
        else:
            passed_s = (datetime.fromisoformat(after.utc) - datetime.fromisoformat(before.utc)).total_seconds()
        at_s.append(at_s[-1] + max(passed_s, 0.0))
        origin = now
    return at_s


def _origin(event: Event) -> str:
    return event.origin if isinstance(event, Opened | Resumed) else ""

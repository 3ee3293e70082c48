"""A shift beside a robot as a Python object: decide, observe, rest; journalled, and resumed where it stopped.

No network, and no disk between a question and its answer. The decision after a cycle is prepared for every reaction
that may be recognised, and for none, while the worker works; what is answered then is read from a table.
"""

import math
import secrets
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn, Self

from fatigue_planner.core.errors import (
    ContradictionError,
    CycleError,
    EvidenceError,
    OtherSituationError,
    OutputFolderError,
    SelectionError,
    listed,
    shortened,
)
from fatigue_planner.core.provenance import versions
from fatigue_planner.live.clock import Clock, SystemClock
from fatigue_planner.live.events import (
    FORMAT,
    MAX_NOTE_LENGTH,
    MAX_SECONDS,
    Advice,
    Closed,
    Contradicted,
    Decided,
    Event,
    Executed,
    Fallback,
    Input,
    Noted,
    Observed,
    Opened,
    Rested,
    Resumed,
    Skipped,
    WorkerChanged,
)
from fatigue_planner.live.journal import Journal
from fatigue_planner.live.journal_file import Stored, body_of
from fatigue_planner.live.shift import LATE_CYCLES, Adviser, Choice, Shift
from fatigue_planner.live.state import Counts, Robot, SessionState, joint_fatigue
from fatigue_planner.live.table import Prepared, Table
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.registry import policy as policy_settings
from fatigue_planner.pomdp.scenario import Scenario

DEFAULT_POLICY = {"kind": "lookahead", "depth": 2, "leaf_value": "bound"}
# What passes between two cycles of a running robot is no rest.
MIN_IDLE_S = 1.0
# After so many cycles of which nothing was seen, the belief says little: the schedule decides.
UNSEEN_LIMIT = 20
MAX_PSEUDONYM_LENGTH = 64


@dataclass(frozen=True)
class CycleDecision:
    """What the robot should do in a cycle.

    action: by name. fallback: "none" where the policy decided, else what did. prepared: it was ready before it was
        asked for. late: it took longer than the deadline.
    recorded: the number of the last event that was handed over to the journal; durable_up_to: of the last on the disk.
        What is newer than that should be kept, and said again after a restart.

    >>> with fp.Session.open(folder / "example.fatplan", scenario) as session:
    ...     session.decide().fallback
    'none'
    """

    cycle: int
    action: str
    reason: str
    fallback: Fallback
    prepared: bool
    late: bool
    recorded: int
    durable_up_to: int


class Session:
    """A shift: ask what to do, say what was done and seen. Calls may come from several threads.

    >>> with fp.Session.open(folder / "shift.fatplan", scenario) as session:
    ...     first = session.decide()
    ...     second = session.observe(first.cycle, observation="arm")
    >>> (first.cycle, second.cycle), second.action in scenario.model.actions
    ((1, 2), True)
    """

    def __init__(
        self, journal: Journal, shift: Shift, adviser: Adviser, table: Table, deadline_s: float, clock: Clock
    ) -> None:
        """See `open`, which makes sessions."""
        self._journal, self._shift, self._adviser, self._table = journal, shift, adviser, table
        self._deadline_s, self._clock = deadline_s, clock
        self._lock = threading.Lock()
        self._pending: CycleDecision | None = None
        self._prepared: Choice | None = None
        self._recorded = -1
        # what the robot said it does in the cycle going on, and of which cycle it spoke last; 0: of none
        self._told: Executed | None = None
        self._robot_cycle, self._robot_silent = 0, False
        # by the clock: when the last cycle or pause ended, and when workers who are away had left
        self._ended_s = clock.seconds()
        self._left_s: dict[str, float] = {}
        self.counts = Counts()

    @classmethod
    def open(
        cls,
        journal: str | Path,
        scenario: Scenario,
        policy: str | Mapping[str, Any] | PolicySettings | None = None,
        deadline_s: float = 0.05,
        safe_action: str | None = None,
        clock: Clock | None = None,
        experiment: str = "",
        cache: str = "",
    ) -> Self:
        """Begin a shift, or go on with the one in the journal. Everything is compiled before this returns.

        policy: by default an exact lookahead over two cycles with cyclic plans beyond. deadline_s: what takes longer is
            counted as late. safe_action: what is left to do where nothing else decides; by default the action that
            costs least in the first cycle. clock: by default the machine's. experiment, cache: where the report finds
            them, from the journal's folder.

        Raises SelectionError for a policy that cannot decide from the belief alone or is too slow, OtherSituationError
        if the journal's shift had another task, policy or safe action, and what `Journal` raises.
        """
        settings = policy_settings(DEFAULT_POLICY if policy is None else policy)
        clock = clock or SystemClock()
        model = scenario.model
        if not 0 < deadline_s < math.inf:
            raise SelectionError(f"deadline_s = {deadline_s}: should be a positive number of seconds.")
        trial = Shift(scenario, settings, "")
        if safe_action is None:
            safe_action = model.actions[int(trial.belief.expected_rewards().argmax())]
        elif safe_action not in model.actions:
            raise SelectionError(f"safe_action {safe_action!r}: should be one of {listed(model.actions)}.")
        adviser, for_table = (Adviser(scenario, settings, model.actions.index(safe_action)) for _ in range(2))
        warm_up(trial, adviser, deadline_s)
        opened = Opened(
            format=FORMAT,
            session=secrets.token_hex(8),
            scenario=scenario.digest,
            scenario_name=scenario.name,
            actions=model.actions,
            policy=settings.plain(),
            policy_sources=settings.sources(),
            safe_action=safe_action,
            deadline_s=deadline_s,
            versions=versions(),
            origin=clock.origin(),
            rehearsal=clock.is_rehearsal(),
            experiment=experiment,
            cache=cache,
        )
        written = Journal(Path(journal))
        try:
            events = _since_opened(written.events)
            found = events[0].event if events else opened
            assert isinstance(found, Opened)
            _check_same(found, opened, Path(journal))
            shift = Shift(scenario, settings, found.session)
            session = cls(written, shift, adviser, Table(shift, for_table), deadline_s, clock)
            if not events:
                session._record(opened)
            else:
                session._replay(events)
                session._record(Resumed(origin=clock.origin()))
        except BaseException:
            written.close()
            raise
        return session

    def decide(self, cycle: int | None = None) -> CycleDecision:
        """What to do in this cycle; asked twice, the same answer.

        cycle: if it is the one after that which was decided last, nothing was seen of that. Raises CycleError for any
        other.
        """
        with self._turn() as began:
            if cycle == self._shift.cycle + 1 and self._pending is not None:
                unseen = self._kept(Observed(cycle=self._shift.cycle, executed=self._doing(self._pending.action)))
                self._end(unseen.model_copy(update={"idle_s": self._idle(unseen)}))
            elif cycle is not None and cycle != self._shift.cycle:
                raise CycleError(f"cycle {cycle}: cannot be decided; the cycle to decide is {self._shift.cycle}.")
            return self._decided(began)

    def executed(self, cycle: int, action: str | None = None) -> CycleDecision:
        """What the robot does in this cycle, as it says itself; None: it does not answer. The decision stands.

        It counts where nothing else is said when the cycle ends. Said again, it changes nothing. Raises CycleError for
        a cycle that is neither going on nor among the last ones, ContradictionError if something else was said before.
        """
        with self._turn() as began:
            actions = self._shift.scenario.model.actions
            if action is not None and action not in actions:
                raise EvidenceError(f"action {shortened(action)}: should be one of {listed(actions)}.")
            self._check_cycle(cycle)
            event = Executed(cycle=cycle, action=action)
            before = self._shift.recent(cycle)
            if cycle == self._shift.cycle:
                known = None if self._told is None else self._told.action
            else:
                known = before.executed if isinstance(before, Observed) else None
            if action is not None and known is not None and action != known:
                self._contradict(event, f"the robot did {known}, was said before")
            if not self._robot_silent if action is None else self._robot_silent or cycle > self._robot_cycle:
                self._record(event)
                self._hear(event)
                if cycle == self._shift.cycle:
                    self._prepare()
            return self._decided(began)

    def observe(
        self,
        cycle: int,
        executed: str | None = None,
        observation: str | None = None,
        likelihood: Mapping[str, float] | None = None,
        duration_s: float | None = None,
    ) -> CycleDecision:
        """A cycle has ended; the decision for the next.

        executed: the action that the robot did, by default the one that was decided. observation: the reaction that was
        recognised, or likelihood: how likely what was measured is under every reaction, by name; neither: nothing was
        seen. duration_s: of the cycle, by default as planned. What the clock says has passed beyond it since the cycle
        before was rest.

        Said again, it changes nothing. Said of one of the last cycles, of which nothing had been seen, it is taken
        late. Raises CycleError for another cycle, ContradictionError if something else was said before, EvidenceError
        for what is no observation.
        """
        with self._turn() as began:
            event = self._checked(cycle, executed, observation, likelihood, duration_s)
            before = self._shift.recent(cycle)
            if before is None:
                self._end(event.model_copy(update={"idle_s": self._idle(event)}))
            elif _says_the_same(event, before):
                pass
            elif isinstance(before, Observed) and before.is_blind:
                self._take(event.model_copy(update={"idle_s": before.idle_s, "late": True}))
            else:
                self._contradict(event, "was observed otherwise before")
            return self._decided(began)

    def skip(self, duration_s: float | None = None) -> CycleDecision:
        """The worker did nothing in this cycle, for so long (by default since the last one); the next decision."""
        with self._turn() as began:
            passed_s = min(max(self._clock.seconds() - self._ended_s, 0.0), MAX_SECONDS)
            seconds = _seconds("duration_s", passed_s if duration_s is None else duration_s)
            self._end(Skipped(cycle=self._shift.cycle, duration_s=seconds))
            return self._decided(began)

    def rest(self, seconds: float) -> CycleDecision:
        """A pause of so many seconds before this cycle; the decision, which is made anew."""
        with self._turn() as began:
            self._take(Rested(seconds=_seconds("seconds", seconds)))
            return self._decided(began)

    def worker(self, pseudonym: str) -> CycleDecision:
        """From now on another worker, by a pseudonym; one who was here before has rested in between."""
        if not isinstance(pseudonym, str) or not 0 < len(pseudonym.strip()) <= MAX_PSEUDONYM_LENGTH:
            raise SelectionError(
                f"pseudonym {shortened(pseudonym)}: should be a text of 1 to {MAX_PSEUDONYM_LENGTH} characters."
            )
        with self._turn() as began:
            random = self._journal.workers.get(pseudonym)
            if random is None:
                random = secrets.token_hex(8)
                self._journal.join(random, pseudonym)
            if random != self._shift.worker:
                left_s = self._left_s.get(random)
                away_s = None if left_s is None else min(max(self._clock.seconds() - left_s, 0.0), MAX_SECONDS)
                self._take(WorkerChanged(worker=random, away_s=away_s))
            return self._decided(began)

    def advise(self, on: bool) -> CycleDecision:
        """Whether a belief is kept of this worker and decides, or the schedule, which knows nothing of him.

        It holds from the next cycle on. Switched off, what was believed of him is forgotten at once, and of a cycle
        only what the robot did is kept; switched on again, he is a newcomer.
        """
        with self._turn() as began:
            self._take(Advice(on=on))
            return self._decided(began)

    def note(self, text: str) -> None:
        """Write a remark into the journal."""
        with self._lock:
            self._record(Noted(text=text[:MAX_NOTE_LENGTH]))

    def state(self) -> SessionState:
        """Where the shift stands, for people to look at."""
        with self._lock:
            pending = self._pending
            return SessionState(
                cycle=self._shift.cycle,
                action=None if pending is None else pending.action,
                fallback="none" if pending is None else pending.fallback,
                since_s=max(self._clock.seconds() - self._ended_s, 0.0),
                worker=self._shift.worker,
                advised=self._shift.advised,
                counts=replace(self.counts),
                joints=joint_fatigue(self._shift.belief) if self._shift.advised else (),
                recorded=self._recorded,
                durable_up_to=self._journal.durable_up_to,
                fault=self._journal.fault,
                robot=self._robot(),
                rehearsal=self._clock.is_rehearsal(),
            )

    @property
    def cycle(self) -> int:
        """The number of the cycle that comes or goes on."""
        return self._shift.cycle

    def digest(self) -> str:
        """SHA-256 of the belief and of where the shift stands."""
        with self._lock:
            return self._shift.digest()

    def close(self) -> None:
        """End the session in good order. Raises OutputFolderError if not everything could be recorded."""
        with self._lock:
            self._table.close()
            self._record(Closed())
            self._journal.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OutputFolderError) if error else nullcontext():
            self.close()

    @contextmanager
    def _turn(self) -> Iterator[float]:
        """One call at a time; when it began."""
        began = time.perf_counter()
        with self._lock:
            yield began

    def _decided(self, began: float) -> CycleDecision:
        if self._pending is None:
            cycle, prepared = self._shift.cycle, self._prepared
            if not self._shift.advised or self.counts.unseen_in_a_row >= UNSEEN_LIMIT:
                choice, prepared = self._adviser.without_belief(cycle), None
            else:
                choice = prepared or self._adviser.choose(self._shift.belief, cycle)
            took_s = time.perf_counter() - began
            event = Decided(
                cycle=cycle,
                action=self._shift.belief.model.actions[choice.action],
                reason=choice.reason,
                fallback=choice.fallback,
                prepared=prepared is not None,
                late=took_s > self._deadline_s,
                duration_s=took_s,
            )
            self._record(event)
            self._account(event)
            self._stand(event)
            self._prepare()
        assert self._pending is not None
        return replace(self._pending, recorded=self._recorded, durable_up_to=self._journal.durable_up_to)

    def _stand(self, event: Decided) -> None:
        """From now on this is what was decided for the cycle."""
        self._pending = CycleDecision(
            event.cycle, event.action, event.reason, event.fallback, event.prepared, event.late, -1, -1
        )
        self._prepared = None

    def _prepare(self) -> None:
        """Prepare what may follow the cycle that was decided."""
        if self._pending is not None and self._shift.advised:
            self._table.prepare(self._shift.belief, self._pending.cycle, self._doing(self._pending.action))

    def _doing(self, decided: str) -> str:
        """What the robot does in the cycle going on: what it said itself, else what was decided."""
        told = None if self._told is None else self._told.action
        return decided if told is None else told

    def _hear(self, event: Executed) -> None:
        """The robot said what it does, or that it does not answer was said."""
        self._robot_silent = event.action is None
        if event.action is not None:
            self._robot_cycle = event.cycle
            if event.cycle == self._shift.cycle:
                self._told = event

    def _robot(self) -> Robot:
        """Whether the robot says what it does; one that said nothing of the cycle before is unreachable."""
        if self._robot_silent or 0 < self._robot_cycle < self._shift.cycle - 1:
            return "unreachable"
        return "answers" if self._robot_cycle else "unknown"

    def _contradict(self, event: Observed | Executed, why: str) -> NoReturn:
        contradiction = Contradicted(cycle=event.cycle, said=body_of(event))
        self._record(contradiction)
        self._account(contradiction)
        raise ContradictionError(f"cycle {event.cycle}: {why}; the first stands.")

    def _check_cycle(self, cycle: object) -> None:
        """Raise CycleError unless something may be said of this cycle."""
        if isinstance(cycle, bool) or not isinstance(cycle, int) or cycle < 1:
            raise CycleError(f"cycle {shortened(cycle)}: should be a number from 1.")
        if cycle != self._shift.cycle and self._shift.recent(cycle) is None:
            raise CycleError(
                f"cycle {cycle}: cannot be observed; the cycle going on is {self._shift.cycle}, and "
                f"only the last {LATE_CYCLES} before it may be told late."
            )

    def _checked(
        self,
        cycle: int,
        executed: str | None,
        observation: str | None,
        likelihood: Mapping[str, float] | None,
        duration_s: float | None,
    ) -> Observed:
        """What was said of a cycle. Raises EvidenceError, CycleError."""
        model = self._shift.scenario.model
        self._check_cycle(cycle)
        before = self._shift.recent(cycle)
        told = None if cycle != self._shift.cycle or self._told is None else self._told.action
        if executed is None:
            decided = self._pending if self._pending is not None and self._pending.cycle == cycle else before
            executed = told or getattr(decided, "action", None) or getattr(decided, "executed", None)
            if executed is None:
                raise CycleError(f"cycle {cycle}: nothing was decided for it; say what the robot did (executed).")
        if executed not in model.actions:
            raise EvidenceError(f"executed {shortened(executed)}: should be one of {listed(model.actions)}.")
        if observation is not None and likelihood is not None:
            raise EvidenceError("observation and likelihood: give one of them.")
        if observation is not None and observation not in model.observations:
            raise EvidenceError(f"observation {shortened(observation)}: should be one of {listed(model.observations)}.")
        if likelihood is not None:
            likelihood = _likelihood(likelihood, model.outcomes)
        event = Observed(
            cycle=cycle,
            executed=executed,
            observation=observation,
            likelihood=likelihood,
            duration_s=None if duration_s is None else _seconds("duration_s", duration_s),
        )
        event = self._kept(event, before)
        if told is not None and executed != told:
            self._contradict(event, f"the robot did {told}, as it said itself")
        return event

    def _kept(self, event: Observed, before: Observed | Skipped | None = None) -> Observed:
        """What may be kept of what was said of a cycle, of which something may have been kept before."""
        was_off = before.off if isinstance(before, Observed) else before is None and not self._shift.advised
        return event.without_worker() if was_off else event

    def _idle(self, event: Observed) -> float:
        """Seconds between the end of the cycle before and the beginning of the one that has just ended."""
        if event.off:
            return 0.0
        planned_s = self._shift.planned_s if event.duration_s is None else event.duration_s
        idle_s = self._clock.seconds() - self._ended_s - planned_s
        return 0.0 if idle_s < MIN_IDLE_S else min(idle_s, MAX_SECONDS)

    def _end(self, event: Observed | Skipped) -> None:
        """The cycle going on has ended so."""
        prepared = self._table.take(event) if isinstance(event, Observed) else None
        self._take(event, prepared)
        self._prepared = prepared.choice if prepared else None

    def _take(self, event: Input, prepared: Prepared | None = None) -> None:
        self._record(event)
        self._go_on(event, self._clock.seconds(), prepared)
        self._prepare()

    def _go_on(self, event: Input, at_s: float, prepared: Prepared | None = None) -> None:
        """Stand where an input of this moment leads. What was decided stands after advice, and a cycle told late."""
        self._account(event)
        if isinstance(event, WorkerChanged):
            self._left_s[self._shift.worker] = at_s
        self._shift.take(event, prepared.belief if prepared else None)
        self.counts.surprised += self._shift.belief.surprised and isinstance(event, Observed)
        if isinstance(event, Observed) and event.late:
            return
        if isinstance(event, Advice):
            self._prepared = None
            return
        self._pending = None
        if isinstance(event, Observed | Skipped):
            self._told = None
            # the robot need not speak of a cycle in which it did nothing
            self._robot_cycle += isinstance(event, Skipped) and self._robot_cycle == event.cycle - 1
        self._ended_s = min(self._ended_s + event.seconds, at_s) if isinstance(event, Rested) else at_s

    def _account(self, event: Event) -> None:
        self.counts.add(event, None if self._pending is None else self._pending.action)

    def _record(self, event: Event) -> None:
        if not self._journal.fault:
            self._recorded = self._journal.append(event, float(self._clock.seconds()), self._clock.utc().isoformat())

    def _replay(self, events: list[Stored]) -> None:
        """Stand where the journal's shift stands; its events begin with that of its opening."""
        self._recorded = events[-1].number
        origin = ""
        for stored in events:
            event = stored.event
            if isinstance(event, Opened | Resumed):
                origin = event.origin
            if isinstance(event, Input):
                self._go_on(event, self._now(stored, origin))
                continue
            self._account(event)
            if isinstance(event, Decided):
                self._stand(event)
            elif isinstance(event, Executed):
                self._hear(event)
        self._prepare()

    def _now(self, stored: Stored, origin: str) -> float:
        """When an event was, by this clock; after the machine has started anew, by the time of day."""
        if origin == self._clock.origin():
            return stored.seconds
        ago_s = (self._clock.utc() - datetime.fromisoformat(stored.utc).astimezone(UTC)).total_seconds()
        return self._clock.seconds() - max(ago_s, 0.0)


def warm_up(shift: Shift, adviser: Adviser, deadline_s: float) -> None:
    """Compile everything by running it on a shift that is thrown away.

    Raises SelectionError if a decision takes longer than the deadline even then.
    """
    model = shift.scenario.model
    shift.belief.warm_up()
    times_s: dict[tuple[str | None, str], float] = {}  # of the fastest turn: another program may disturb the others
    for turn in range(3):
        for seen in (None, *model.observations):
            for action in model.actions:
                event = Observed(cycle=shift.cycle, executed=action, observation=seen, idle_s=60.0 * turn)
                shift.take(event)
                begin = time.perf_counter()
                adviser.choose(shift.belief, shift.cycle)
                took_s = time.perf_counter() - begin
                times_s[seen, action] = min(took_s, times_s.get((seen, action), took_s))
        even = dict.fromkeys(model.outcomes, 1.0)
        shift.take(Observed(cycle=shift.cycle, executed=model.actions[0], likelihood=even, duration_s=1.0))
    slowest_s = max(times_s.values())
    if slowest_s > deadline_s:
        raise SelectionError(
            f"the policy took {1000 * slowest_s:.0f} ms for a decision, more than deadline_s = {deadline_s:g}; choose "
            "one that looks less far ahead, or a later deadline."
        )


def _since_opened(events: list[Stored]) -> list[Stored]:
    """The events of the shift that was opened last; none in a new journal."""
    opened = [number for number, one in enumerate(events) if isinstance(one.event, Opened)]
    return events[opened[-1] :] if opened else []


def _check_same(before: Opened, now: Opened, path: Path) -> None:
    """Raise OtherSituationError unless both are of the same shift."""
    parts = {
        "the scenario (task, worker, reactions or belief)": (before.scenario, now.scenario),
        "the actions": (before.actions, now.actions),
        "the policy": ((before.policy, before.policy_sources), (now.policy, now.policy_sources)),
        "the safe action": (before.safe_action, now.safe_action),
        "the program's version": (before.versions, now.versions),
        "the clock (the machine's, or a rehearsal's)": (before.rehearsal, now.rehearsal),
    }
    different = [name for name, (old, new) in parts.items() if old != new]
    if different:
        raise OtherSituationError(
            f"{path}: the shift was begun with other settings: {listed(different)} changed. Its belief cannot go on. "
            "Begin another journal, or go on with what it was begun with."
        )


def _says_the_same(event: Observed, before: Observed | Skipped) -> bool:
    return isinstance(before, Observed) and event == before.model_copy(update={"idle_s": 0.0, "late": False})


def _seconds(name: str, value: object) -> float:
    """A number of seconds. Raises EvidenceError."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= MAX_SECONDS:
        raise EvidenceError(f"{name} {shortened(value)}: should be a number of seconds from 0 to {MAX_SECONDS:.0f}.")
    return float(value)


def _likelihood(given: object, outcomes: tuple[str, ...]) -> dict[str, float]:
    """Likelihoods by reaction. Raises EvidenceError."""
    what = f"should be numbers from 0 to 1, not all 0, by reaction: {listed(outcomes)}"
    if not isinstance(given, Mapping) or not given:
        raise EvidenceError(f"likelihood {shortened(given)}: {what}.")
    for name, value in given.items():
        if name not in outcomes:
            raise EvidenceError(f"likelihood.{shortened(name)}: {what}.")
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1:
            raise EvidenceError(f"likelihood.{name} = {shortened(value)}: {what}.")
    if not any(given.values()):
        raise EvidenceError(f"likelihood: {what}.")
    return {name: float(value) for name, value in given.items()}

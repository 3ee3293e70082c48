"""A shift beside a robot as a Python object: decide, observe, rest; journalled, and resumed where it stopped.

No network, and no disk between a question and its answer. The decision after a cycle is prepared for every reaction
that may be recognised, and for none, while the worker works; what is answered then is read from a table.
"""

import secrets
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext, suppress
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn, Self

from fatigue_planner.core.errors import (
    ContradictionError,
    CycleError,
    EvidenceError,
    OutputFolderError,
    SelectionError,
    shortened,
)
from fatigue_planner.live import said
from fatigue_planner.live.clock import Clock, ClockWatch, SystemClock
from fatigue_planner.live.events import (
    MAX_NOTE_LENGTH,
    Acknowledged,
    Advice,
    AlarmSettings,
    CameLate,
    Closed,
    Contradicted,
    Decided,
    Event,
    Executed,
    Input,
    Noted,
    Observed,
    Opened,
    Refused,
    Rested,
    Resumed,
    SearchFailed,
    Skipped,
    WorkerChanged,
)
from fatigue_planner.live.journal import Journal
from fatigue_planner.live.journal_file import Stored, body_of
from fatigue_planner.live.limits import MAX_SECONDS
from fatigue_planner.live.opening import changes, first_rules, off_after, opening, refuse, search_settings, since_opened
from fatigue_planner.live.pauses import Levels
from fatigue_planner.live.realtime import OLD_OBJECTS
from fatigue_planner.live.replay import last_origin, replay, time_of
from fatigue_planner.live.rules import DEFAULT_POLICY, UNSEEN_LIMIT, Rules, from_json, made
from fatigue_planner.live.searcher import Searcher, Task, unsearched
from fatigue_planner.live.shift import Choice, Shift
from fatigue_planner.live.standing import Standing
from fatigue_planner.live.state import DEGRADED_AFTER, Counts, SessionState, joint_fatigue, pauses
from fatigue_planner.live.table import Table
from fatigue_planner.live.turn import Answered, CycleDecision, Turn
from fatigue_planner.live.watch import Watch
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.registry import policy as policy_settings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.scenario import Scenario


class Session:
    """A shift: ask what to do, say what was done and seen. Calls may come from several threads.

    >>> with fp.Session.open(folder / "shift.fatplan", scenario) as session:
    ...     first = session.decide()
    ...     second = session.observe(first.cycle, observation="arm")
    >>> (first.cycle, second.cycle), second.action in scenario.model.actions
    ((1, 2), True)
    """

    def __init__(
        self,
        journal: Journal,
        shift: Shift,
        rules: Rules,
        watch: Watch,
        search: PolicySettings | None,
        clock: Clock,
    ) -> None:
        """See `open`, which makes sessions."""
        self._journal, self._shift, self._clock = journal, shift, clock
        self._searcher = None if search is None else Searcher(shift.scenario, search, shift.session, self._found)
        self._table = Table(shift, rules.for_table, *([self._searcher.search] if self._searcher else []))
        self._standing = Standing(shift, rules, watch, clock.seconds())
        self._watch, self._clock_watch = watch, ClockWatch(clock)
        self._answered: Answered | None = None
        self._changing, lock = threading.Lock(), threading.Lock()
        self._hold, self._turn = Turn(lock, self._catch_up), Turn(lock, self._begin_turn)
        self._table.catch_up, self._table.look, self._table.foresee = self._stand, self._look, self._foresee
        self._now = float(clock.seconds()), clock.utc()
        self._recorded = self._resumed_at = -1

    @property
    def counts(self) -> Counts:
        """What did not go as planned."""
        with self._hold:
            return self._standing.counts

    @classmethod
    def open(
        cls,
        journal: str | Path,
        scenario: Scenario,
        policy: str | Mapping[str, Any] | PolicySettings | None = None,
        deadline_s: float = 0.05,
        safe_action: str | None = None,
        clock: Clock | None = None,
        alarms: AlarmSettings | None = None,
        search: str | Mapping[str, Any] | PolicySettings | None = None,
        unseen_limit: int = UNSEEN_LIMIT,
        accept: bool = False,
        experiment: str = "",
        cache: str = "",
    ) -> Self:
        """Begin a shift, or go on with the one in the journal. Everything is compiled before this returns.

        policy: by default an exact lookahead over two cycles with cyclic plans beyond. deadline_s: what takes longer is
            counted as late. safe_action: what is left to do where nothing else decides; by default the action that
            costs least in the first cycle. clock: by default the machine's. alarms: when a pause is wanted, from now
            on. search: a policy that improves decisions while the worker works, in a process of its own; where it gave
            no answer the first policy decides. unseen_limit: after so many cycles in a row of which nothing is known
            the schedule decides. accept: where the journal's shift had another situation, begin a new segment, which
            knows nothing of the one before. experiment, cache: where the report finds them, from the journal's folder.

        Raises SelectionError for a policy that cannot decide from the belief alone or is too slow, OtherSituationError
        if the journal's shift had another task, policy or safe action, and what `Journal` raises.
        """
        clock, alarms = clock or SystemClock(), alarms or AlarmSettings()
        settings = policy_settings(DEFAULT_POLICY if policy is None else policy)
        searching = search_settings(search, settings)
        rules = first_rules(scenario, settings, deadline_s, unseen_limit, safe_action)
        opened = opening(scenario, rules, clock, alarms, searching, experiment, cache)
        written = Journal(Path(journal))
        try:
            events = since_opened(written.events)
            found = events[0].event if events else opened
            assert isinstance(found, Opened)
            if changed := changes(found, opened):
                if not accept:
                    refuse(changed, Path(journal))
                opened = opened.model_copy(update={"accepted": tuple(changed), "off": off_after(events)})
                found, events = opened, []
            shift = Shift(scenario, rules.settings, found.session, found.off)
            watch = Watch(scenario.model, alarms, shift.likelihood)
            session = cls(written, shift, rules, watch, searching, clock)
            try:
                if events:
                    session._resume(events, opened)
                else:
                    session._record(opened)
            except BaseException:
                session._stop()
                raise
        except BaseException:
            written.close()
            raise
        OLD_OBJECTS.leave_alone()
        return session

    def decide(self, cycle: int | None = None) -> CycleDecision:
        """What to do in this cycle; asked twice, the same answer.

        cycle: if it is the one after that which was decided last, nothing was seen of that. Raises CycleError for any
        other.
        """
        with self._turn as began:
            done = self._standing.done
            if cycle == self._shift.cycle + 1 and self._standing.pending is not None and done is not None:
                if answer := self._prepared_answer(began, self._shift.cycle, done, None):
                    return answer
                unseen = self._kept(Observed(cycle=self._shift.cycle, executed=done))
                self._take(self._after_rest(unseen))
            elif cycle is not None and cycle != self._shift.cycle:
                raise CycleError(f"cycle {cycle}: cannot be decided; the cycle to decide is {self._shift.cycle}.")
            return self._decided(began)

    def executed(self, cycle: int, action: str | None = None) -> CycleDecision:
        """What the robot does in this cycle, as it says itself; None: it does not answer. The decision stands.

        It counts where nothing else is said when the cycle ends. Said again, it changes nothing. Raises CycleError for
        a cycle that is neither going on nor among the last ones, ContradictionError if something else was said before.
        """
        with self._turn as began:
            if action is not None:
                said.check_action("action", action, self._shift.scenario.model)
            said.check_cycle(cycle, self._shift)
            event = Executed(cycle=cycle, action=action)
            before = self._shift.recent(cycle)
            if cycle == self._shift.cycle:
                known = None if self._standing.told is None else self._standing.told.action
            else:
                known = before.executed if isinstance(before, Observed) else None
            if action is not None and known is not None and action != known:
                self._contradict(event, f"the robot did {known}, was said before")
            if self._standing.is_news(event):
                self._record(event)
                self._standing.hear(event)
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
        recognised, or likelihood: how likely what was measured is under every preference, by name; neither: nothing was
        seen. duration_s: of the cycle, by default as planned. What the clock says has passed beyond it since the cycle
        before was rest.

        Said again, it changes nothing. Said of one of the last cycles, of which nothing had been seen, it is taken
        late. Raises CycleError for another cycle, ContradictionError if something else was said before, EvidenceError
        for what is no observation.
        """
        with self._turn as began:
            is_plain = likelihood is None and duration_s is None
            if is_plain and (answer := self._prepared_answer(began, cycle, executed, observation)):
                return answer
            event = self._checked(cycle, executed, observation, likelihood, duration_s)
            before = self._shift.recent(cycle)
            if before is None:
                self._take(self._after_rest(event))
            elif said.says_the_same(event, before):
                pass
            elif isinstance(before, Observed) and before.is_blind:
                self._take(event.model_copy(update={"idle_s": before.idle_s, "late": True}))
            else:
                self._contradict(event, "was observed otherwise before")
            return self._decided(began)

    def skip(self, duration_s: float | None = None, cycle: int | None = None) -> CycleDecision:
        """The worker did nothing in this cycle, for so long (by default since the last one); the next decision.

        cycle: with it, what is said again changes nothing. Raises CycleError if it is another than the one going on and
        was not skipped.
        """
        with self._turn as began:
            if cycle is not None and cycle != self._shift.cycle:
                said.check_cycle(cycle, self._shift)
                if not isinstance(self._shift.recent(cycle), Skipped):
                    raise CycleError(f"cycle {cycle}: was observed, and cannot be skipped any more.")
                return self._decided(began)
            passed_s = min(self._standing.since_s(self._clock.seconds()), MAX_SECONDS)
            seconds = said.seconds("duration_s", passed_s if duration_s is None else duration_s)
            off = not self._shift.advised
            self._take(Skipped(cycle=self._shift.cycle, duration_s=0.0 if off else seconds, off=off))
            return self._decided(began)

    def rest(self, seconds: float, key: str | None = None) -> CycleDecision:
        """A pause of so many seconds before this cycle; the decision, which is made anew.

        key: a text that names this pause and nobody; with it, what is said again changes nothing. Of a worker who wants
        no belief about him no pause is kept. Raises ContradictionError if that pause was said to be of another length.
        """
        with self._turn as began:
            event = Rested(seconds=said.seconds("seconds", seconds), key=said.key(key))
            before_s = self._standing.rested_s(event.key)
            if before_s is not None and before_s != event.seconds:
                self._contradict(event, f"the pause {event.key} was said to be of {before_s:g} s before")
            if before_s is None and self._shift.advised:
                self._take(event)
            return self._decided(began)

    def worker(self, pseudonym: str) -> CycleDecision:
        """From now on another worker, by a pseudonym; one who was here before has rested in between."""
        pseudonym = said.pseudonym(pseudonym)
        with self._turn as began:
            random = self._journal.workers.get(pseudonym)
            if random is None:
                random = secrets.token_hex(8)
                self._journal.join(random, pseudonym)
            if random != self._shift.worker:
                away_s = self._standing.away_s(random, self._clock.seconds())
                self._take(WorkerChanged(worker=random, away_s=away_s))
            return self._decided(began)

    def advise(self, on: bool) -> CycleDecision:
        """Whether a belief is kept of this worker and decides, or the schedule, which knows nothing of him.

        It holds from the next cycle on. Switched off, what was believed of him is forgotten at once, and of a cycle
        only what the robot did is kept; switched on again, he is a newcomer.
        """
        with self._turn as began:
            self._take(Advice(on=on))
            return self._decided(began)

    def configure(
        self,
        deadline_s: float | None = None,
        unseen_limit: int | None = None,
        policy: str | Mapping[str, Any] | PolicySettings | None = None,
    ) -> CycleDecision:
        """Decide otherwise from the next cycle on, see `open`; what is not given stays. It is compiled and tried first.

        Actions, preferences and what a policy knows cannot be changed in a shift. Raises SelectionError.
        """
        if deadline_s is None and unseen_limit is None and policy is None:
            raise SelectionError("nothing is to be changed: give deadline_s, unseen_limit or policy.")
        with self._changing:
            now = self._standing.coming
            settings = now.settings if policy is None else policy_settings(from_json(policy))
            if settings.knows != self._shift.settings.knows:
                raise SelectionError(f"policy: what it knows ({now.settings.knows}) cannot be changed in a shift.")
            rules = made(
                self._shift.scenario,
                settings,
                now.deadline_s if deadline_s is None else deadline_s,
                now.unseen_limit if unseen_limit is None else unseen_limit,
                now.safe_action,
                1,
            )
            with self._turn as began:
                rules = replace(rules, cycle=self._shift.cycle + 1)
                self._record(rules.event())
                self._rule(rules)
                self._prepare()
                return self._decided(began)

    def acknowledge(self) -> None:
        """Somebody has seen the alarms that are on; they are told again if they still are after `repeat_s`."""
        self._look()
        with self._hold:
            entries = tuple(one.entry for one in self._watch.alarms.now() if not one.acknowledged)
            if entries:
                self._tell(Acknowledged(entries=entries))

    def refused(self, counts: Mapping[str, int]) -> None:
        """Write into the journal that requests were refused, so many by their HTTP status."""
        with self._hold:
            self._tell(Refused(counts=dict(counts)))

    def waited(self, seconds: float) -> None:
        """How long a client waited for an answer, by its own clock; journalled if that is beyond the deadline.

        What waits before this program hears it, or after it has answered, only the client sees. Raises EvidenceError.
        """
        seconds = said.seconds("waited_s", seconds)
        with self._hold:
            if seconds > self._standing.rules.deadline_s:
                self._tell(CameLate(seconds=seconds))

    def note(self, text: str) -> None:
        """Write a remark into the journal."""
        with self._turn:
            try:
                self._record(Noted(text=text[:MAX_NOTE_LENGTH]))
            except ValueError as error:
                raise EvidenceError(f"text {shortened(text)}: should be a text.") from error

    def state(self) -> SessionState:
        """Where the shift stands, for people to look at."""
        levels = self._look()
        with self._hold:
            standing = self._standing
            pending = standing.pending
            return SessionState(
                cycle=self._shift.cycle,
                action=None if pending is None else pending.action,
                fallback="none" if pending is None else pending.fallback,
                since_s=standing.since_s(self._clock.seconds()),
                worker=self._shift.worker,
                advised=self._shift.advised,
                counts=replace(standing.counts),
                planned_s=self._shift.planned_s,
                joints=joint_fatigue(self._shift.belief) if self._shift.advised else (),
                pauses=pauses(self._watch, levels, self._shift, self._clock.seconds()),
                recorded=self._recorded,
                durable_up_to=self._journal.durable_up_to,
                fault=self._journal.fault,
                robot=standing.robot,
                rehearsal=self._clock.is_rehearsal(),
                resumed_at=self._resumed_at,
                actions=self._shift.scenario.model.actions,
                reactions=self._shift.scenario.model.observations,
                degraded=standing.counts.unseen_in_a_row >= DEGRADED_AFTER,
                surprises=standing.fit.surprises,
                judged=standing.fit.judged,
                fits=standing.fit.holds,
                preferences=self._shift.scenario.model.outcomes,
                executed=None if standing.told is None else standing.told.action,
            )

    @property
    def cycle(self) -> int:
        """The number of the cycle that comes or goes on."""
        with self._hold:
            return self._shift.cycle

    def digest(self) -> str:
        """SHA-256 of the belief and of where the shift stands."""
        with self._hold:
            return self._shift.digest()

    def close(self) -> None:
        """End the session in good order; again, do nothing. Raises OutputFolderError if not all could be recorded."""
        if self._journal.is_closed:
            return
        OLD_OBJECTS.look_at()
        self._stop()
        with self._hold:
            self._record(Closed())
            self._journal.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OutputFolderError) if error else nullcontext():
            self.close()

    def _stop(self) -> None:
        """End what works beside. Not to be called in a turn, for which a thread may be waiting."""
        if self._searcher:
            self._searcher.close()
        self._table.close()

    def _begin_turn(self) -> None:
        """Stand where the last turn has led, and record what has happened since then. To be called in a turn."""
        self._catch_up()
        self._now = float(self._clock.seconds()), self._clock.utc()
        for event in self._clock_watch.look(*self._now):
            self._record(event, *self._now)
        for why in self._searcher.faults() if self._searcher else ():
            self._record(SearchFailed(why=why))

    def _prepared_answer(
        self, began: float, cycle: object, executed: object, observation: object
    ) -> CycleDecision | None:
        """The decision for the next cycle, if what is said of the one going on was prepared; else all is checked.

        The answer first: `_catch_up` hands what was said and decided over to the journal, as the next two events, and
        brings the shift to where it leads.
        """
        executed = self._standing.done if executed is None else executed
        if not (type(cycle) is int and type(executed) is str and (observation is None or type(observation) is str)):
            return None
        prepared = self._table.take(cycle, executed, observation) if self._shift.advised else None
        seconds, utc = self._now
        if prepared is None or self._standing.idle_s(prepared.event, seconds):
            return None
        rules = self._standing.rules_in(cycle + 1)
        if observation is None and self._standing.counts.unseen_in_a_row + 1 >= rules.unseen_limit:
            return None
        choice = unsearched(prepared.choice) if self._searcher else prepared.choice
        took_s = time.perf_counter() - began
        answer = CycleDecision(
            cycle + 1,
            self._shift.scenario.model.actions[choice.action],
            choice.reason,
            choice.fallback,
            True,
            took_s > rules.deadline_s,
            self._recorded if self._journal.fault else self._recorded + 2,
            self._journal.durable_up_to,
        )
        self._answered = Answered(prepared, choice, seconds, utc, took_s)
        self._table.answered()
        return answer

    def _catch_up(self) -> None:
        """Go on to where the last prepared answer leads. To be called in a turn."""
        if self._answered is None:
            return
        (prepared, choice, seconds, utc, took_s), self._answered = self._answered, None
        self._record(prepared.event, seconds, utc)
        self._standing.go_on(prepared.event, seconds, prepared.belief)
        self._decide(choice, took_s, True, seconds, utc)

    def _stand(self) -> None:
        """Stand where the last turn has led. Not to be called in a turn."""
        with self._hold:
            pass

    def _decided(self, began: float) -> CycleDecision:
        standing = self._standing
        pending = standing.pending
        if pending is None:
            cycle, rules = self._shift.cycle, standing.rules
            if not self._shift.advised or standing.counts.unseen_in_a_row >= rules.unseen_limit:
                choice = rules.adviser.without_belief(cycle)
            else:
                choice = rules.adviser.choose(self._shift.belief, cycle)
                choice = unsearched(choice) if self._searcher else choice
            pending = self._decide(choice, time.perf_counter() - began, False)
        return CycleDecision(
            pending.cycle,
            pending.action,
            pending.reason,
            pending.fallback,
            pending.prepared,
            pending.late,
            self._recorded,
            self._journal.durable_up_to,
        )

    def _decide(
        self, choice: Choice, took_s: float, prepared: bool, seconds: float | None = None, utc: datetime | None = None
    ) -> Decided:
        """Stand by a choice for the cycle that comes, made at a moment, by default now, and prepare what may follow."""
        decided = Decided(
            cycle=self._shift.cycle,
            action=self._shift.scenario.model.actions[choice.action],
            reason=choice.reason,
            fallback=choice.fallback,
            prepared=prepared,
            late=took_s > self._standing.rules.deadline_s,
            duration_s=took_s,
        )
        self._record(decided, seconds, utc)
        self._standing.decide(decided)
        self._prepare()
        return decided

    def _prepare(self) -> None:
        """Prepare what may follow the cycle that was decided."""
        pending, done = self._standing.pending, self._standing.done
        if pending is not None and done is not None and self._shift.advised:
            self._table.prepare(self._shift.belief, pending.cycle, done)

    def _contradict(self, event: Observed | Executed | Rested, why: str) -> NoReturn:
        cycle = self._shift.cycle if isinstance(event, Rested) else event.cycle
        self._tell(Contradicted(cycle=cycle, said=body_of(event)))
        raise ContradictionError(f"cycle {cycle}: {why}; the first stands.")

    def _checked(
        self,
        cycle: int,
        executed: str | None,
        observation: str | None,
        likelihood: Mapping[str, float] | None,
        duration_s: float | None,
    ) -> Observed:
        """What was said of a cycle. Raises EvidenceError, CycleError."""
        said.check_cycle(cycle, self._shift)
        before = self._shift.recent(cycle)
        told = self._standing.told.action if cycle == self._shift.cycle and self._standing.told else None
        if executed is None:
            pending = self._standing.pending
            decided = pending if pending is not None and pending.cycle == cycle else before
            executed = told or getattr(decided, "action", None) or getattr(decided, "executed", None)
            if executed is None:
                raise CycleError(f"cycle {cycle}: nothing was decided for it; say what the robot did (executed).")
        event = said.observed(cycle, executed, observation, likelihood, duration_s, self._shift.scenario.model)
        event = self._kept(event, before)
        if told is not None and executed != told:
            self._contradict(event, f"the robot did {told}, as it said itself")
        return event

    def _kept(self, event: Observed, before: Observed | Skipped | None = None) -> Observed:
        """What may be kept of what was said of a cycle, of which something may have been kept before."""
        was_off = before.off if isinstance(before, Observed) else before is None and not self._shift.advised
        return event.without_worker() if was_off else event

    def _after_rest(self, event: Observed) -> Observed:
        """The cycle that has just ended, after the rest before it."""
        idle_s = self._standing.idle_s(event, self._clock.seconds())
        return event.model_copy(update={"idle_s": idle_s}) if idle_s else event

    def _take(self, event: Input) -> None:
        self._record(event)
        self._standing.go_on(event, self._clock.seconds())
        self._prepare()

    def _tell(self, event: Event) -> None:
        """Record an event that is no input, and stand where it leads."""
        self._record(event)
        self._standing.account(event, self._clock.seconds())

    def _look(self) -> Levels:
        """Look at the belief, and tell the alarms that are due. Not to be called in a turn."""
        with self._hold:
            belief = self._shift.belief
        levels = self._watch.look(belief)
        with self._hold:
            if belief is self._shift.belief and self._shift.advised:
                for event in self._watch.alarms.due(levels.robot, self._shift.cycle, self._clock.seconds()):
                    self._tell(event)
        return levels

    def _foresee(self, has_ended: Callable[[], bool]) -> None:
        """Find out what will pass the limit, as long as the cycle goes on."""
        with self._hold:
            belief, cycle, is_known = self._shift.belief, self._shift.cycle, self._shift.advised
            by_belief = self._standing.counts.unseen_in_a_row < self._standing.rules.unseen_limit

        def plan(then: Belief, n: int) -> int:
            if has_ended():
                raise InterruptedError
            adviser = self._table.adviser
            choice = adviser.choose(then, cycle + n) if by_belief else adviser.without_belief(cycle + n)
            return choice.action

        if is_known:
            with suppress(InterruptedError):
                self._watch.foresee(belief, cycle, plan)

    def _record(self, event: Event, seconds: float | None = None, utc: datetime | None = None) -> None:
        """Hand an event of this moment, by default of now, over to the journal."""
        seconds = float(self._clock.seconds()) if seconds is None else seconds
        number = self._journal.append(event, seconds, self._clock.utc() if utc is None else utc)
        if not self._journal.fault:
            self._recorded = number

    def _rule(self, rules: Rules) -> None:
        """Decide by these from their cycle on."""
        self._standing.coming = rules
        self._table.adviser = rules.for_table

    def _found(self, task: Task, choice: Choice) -> bool:
        return self._table.improve(task, choice)

    def _resume(self, events: list[Stored], now: Opened) -> None:
        """Go on with the journal's shift. What decides is as it was last, but for what is given otherwise now."""
        self._recorded = events[-1].number
        standing, clock, last = self._standing, self._clock, events[-1]
        replay(standing, events, clock, self._journal.path)
        self._table.adviser = standing.coming.for_table
        self._prepare()
        origin = last_origin(events)
        if origin == clock.origin():
            self._clock_watch.stood(last.seconds, last.utc)
        away_s = max(clock.seconds() - time_of(last, origin, clock), 0.0)
        self._record(Resumed(origin=clock.origin(), away_s=away_s, alarms=now.alarms))
        self._resumed_at = self._recorded
        begun = events[0].event
        assert isinstance(begun, Opened)
        coming, given = standing.coming, (now.deadline_s, now.unseen_limit)
        if given not in ((begun.deadline_s, begun.unseen_limit), (coming.deadline_s, coming.unseen_limit)):
            rules = replace(coming, cycle=self._shift.cycle, deadline_s=given[0], unseen_limit=given[1])
            self._record(rules.event())
            self._rule(rules)
            standing.rules = rules

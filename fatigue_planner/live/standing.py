"""Where a session stands: a function of its events and their times, so that a replay comes to the same."""

from fatigue_planner.live.events import (
    UNCLEAR,
    Advice,
    Decided,
    Event,
    Executed,
    Input,
    Observed,
    Rested,
    Skipped,
    WorkerChanged,
)
from fatigue_planner.live.fit import Fit
from fatigue_planner.live.limits import MAX_SECONDS
from fatigue_planner.live.rules import Rules
from fatigue_planner.live.shift import Shift
from fatigue_planner.live.state import Counts, Robot
from fatigue_planner.live.watch import Watch
from fatigue_planner.pomdp.beliefs.belief import Belief

# What passes between two cycles of a running robot is no rest.
MIN_IDLE_S = 1.0


class Standing:
    """Where a session stands.

    rules: by which decisions are made; coming: by which from `coming.cycle` on. pending: what was decided for the cycle
    that comes or goes on. told: what the robot said it does in that cycle.
    """

    def __init__(self, shift: Shift, rules: Rules, watch: Watch, at_s: float) -> None:
        """at_s: now, by the session's clock."""
        self.shift, self.watch = shift, watch
        self.rules = self.coming = rules
        self.counts, self.fit = Counts(), Fit()
        self.pending: Decided | None = None
        self.told: Executed | None = None
        # of which cycle the robot spoke last; 0: of none
        self._robot_cycle, self.robot_silent = 0, False
        # by the clock: when the last cycle or pause ended, and when that was of workers who are away
        self._ended_s = at_s
        self._left_s: dict[str, float] = {}
        self._rests: dict[str, float] = {}  # pauses that have a name

    def decide(self, event: Decided) -> None:
        """From now on this is what was decided for the cycle."""
        self.counts.decide(event)
        self.pending = event

    def go_on(self, event: Input, at_s: float, after: Belief | None = None) -> None:
        """Stand where an input of this moment leads, with the belief after it if that is known already.

        What was decided stands after advice, and a cycle told late.
        """
        before = self.shift.before(event.cycle) if isinstance(event, Observed) and self.shift.advised else None
        self.account(event, at_s, before)
        if isinstance(event, WorkerChanged):
            self._left_s[self.shift.worker] = min(self._ended_s, at_s)  # what has passed since then was rest
        surprised = self.shift.take(event, after)
        match event:
            case Observed():
                unknown = event.is_unclear and UNCLEAR not in self.shift.scenario.model.observations
                surprised = not event.off and (surprised or unknown)
                self.counts.surprised += surprised
                self.fit.add(event, surprised)
                if event.late:
                    return
                self.told = None
            case Skipped():
                self.told = None
                # the robot need not speak of a cycle in which it did nothing
                self._robot_cycle += self._robot_cycle == event.cycle - 1
            case Rested():
                if event.key is not None:
                    self._rests[event.key] = event.seconds
                at_s = self._ended_s + event.seconds  # a pause may be said when it begins, too: then it ends later
            case WorkerChanged():
                self.fit.change(event.worker)
            case Advice():
                if not event.on:
                    self.fit.forget()
                return
        self.pending, self._ended_s = None, at_s
        self.rules = self.rules_in(self.shift.cycle)

    def account(self, event: Event, at_s: float, before: Belief | None = None) -> None:
        """Count and watch an event of this moment, no decision; the belief before a cycle that is to be metered."""
        self.counts.add(event, None if self.pending is None else self.pending.action, self.shift.cycle - 1)
        self.watch.account(event, at_s, self.shift.worker, before)

    def hear(self, event: Executed) -> None:
        """The robot said what it does, or that it does not answer was said."""
        self.robot_silent = event.action is None
        if event.action is not None:
            self._robot_cycle = event.cycle
            if event.cycle == self.shift.cycle:
                self.told = event

    def is_news(self, event: Executed) -> bool:
        """Whether what the robot says changes anything."""
        if event.action is None:
            return not self.robot_silent
        return self.robot_silent or event.cycle > self._robot_cycle

    def rules_in(self, cycle: int) -> Rules:
        """By what is decided in a cycle that comes."""
        return self.coming if cycle >= self.coming.cycle else self.rules

    @property
    def robot(self) -> Robot:
        """Whether the robot says what it does; one that said nothing of the cycle before is unreachable."""
        if self.robot_silent or 0 < self._robot_cycle < self.shift.cycle - 1:
            return "unreachable"
        return "answers" if self._robot_cycle else "unknown"

    @property
    def done(self) -> str | None:
        """What the robot does in the cycle going on: what it said itself, else what was decided, if anything was."""
        told = None if self.told is None else self.told.action
        return told if told is not None or self.pending is None else self.pending.action

    def rested_s(self, key: str | None) -> float | None:
        """How long the pause of this name was, if there was one."""
        return None if key is None else self._rests.get(key)

    def since_s(self, now_s: float) -> float:
        """Seconds since the last cycle or pause ended."""
        return max(now_s - self._ended_s, 0.0)

    def idle_s(self, event: Observed, now_s: float) -> float:
        """Seconds between the end of the cycle before and the beginning of the one that has just ended."""
        if event.off:
            return 0.0
        planned_s = self.shift.planned_s if event.duration_s is None else event.duration_s
        idle_s = now_s - self._ended_s - planned_s
        return 0.0 if idle_s < MIN_IDLE_S else min(idle_s, MAX_SECONDS)

    def away_s(self, worker: str, now_s: float) -> float | None:
        """How long a worker who comes has been away; None for a new one, and one of whom that is not kept."""
        left_s = None if self.shift.is_off(worker) else self._left_s.get(worker)
        return None if left_s is None else min(max(now_s - left_s, 0.0), MAX_SECONDS)

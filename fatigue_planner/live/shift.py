"""The state of a shift as a function of its inputs: equal inputs give equal beliefs and decisions, bit for bit."""

import hashlib
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from fatigue_planner.core.errors import FatplanError, SelectionError
from fatigue_planner.core.random_streams import Vector, random_stream
from fatigue_planner.live.events import UNCLEAR, Advice, Fallback, Input, Observed, Rested, Skipped, WorkerChanged
from fatigue_planner.live.limits import LATE_CYCLES
from fatigue_planner.planners.periodic import PeriodicSettings
from fatigue_planner.planners.policy import Counts, Policy, PolicySettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.fatigue_pomdp import recognition_of
from fatigue_planner.pomdp.scenario import Scenario

# Schedules and other policies that know their actions beforehand are asked for so many; then they begin again.
MAX_CYCLES = 100_000


@dataclass(frozen=True)
class Choice:
    """An action by its index, why, what it fell back to (see events.Fallback), and whether a search has found it."""

    action: int
    reason: str
    fallback: Fallback = "none"
    searched: bool = False


@dataclass(frozen=True)
class _Past:
    """A cycle that has ended: the belief before it, and the inputs from its end to the end of the next one."""

    cycle: int
    belief: Belief
    inputs: list[Input] = field(default_factory=list)


class Adviser:
    """A policy as a shift needs it: what it does depends on the belief, or on the cycle's number, alone.

    Where the policy fails the schedule decides, which needs no belief, and where there is none the safe action.
    """

    def __init__(self, scenario: Scenario, settings: PolicySettings, safe_action: int) -> None:
        """Raise SelectionError for a policy that remembers earlier cycles or draws at random."""
        model = scenario.model
        self._start = scenario.initial_belief(settings.knows, model, random_stream(0, "live"))
        self._policy = settings.build()
        self._ahead = _known_beforehand(self._policy, self._start)
        self._safe = Choice(safe_action, "the safe action", "safe_action")
        try:
            self._schedule = _known_beforehand(PeriodicSettings(kind="periodic").build(), self._start)
        except FatplanError:  # such as a cost that is no quadratic
            self._schedule = None
        if self._ahead is None and self._policy.rule() is None:
            raise SelectionError(
                f"policy {settings.kind!r}: remembers earlier cycles or draws at random; beside a robot a decision "
                "must follow from the belief alone. Choose lookahead, greedy or a schedule."
            )

    def choose(self, belief: Belief, cycle: int) -> Choice:
        """What the robot should do in a cycle."""
        if self._ahead is not None:
            return Choice(int(self._ahead[(cycle - 1) % MAX_CYCLES]), "the schedule")
        try:
            decision = self._policy.act(belief, random_stream(0, "live decision", cycle))
        except (FatplanError, ArithmeticError, ValueError) as error:
            return replace(self.without_belief(cycle), reason=f"the policy failed: {error}")
        return Choice(decision.action, decision.reason)

    def without_belief(self, cycle: int) -> Choice:
        """What the robot should do where the belief must not decide: the schedule's action, or the safe one."""
        if self._schedule is None:
            return self._safe
        return Choice(int(self._schedule[(cycle - 1) % MAX_CYCLES]), "the schedule, which needs no belief", "schedule")


class Shift:
    """Where a shift stands.

    cycle: the number of the cycle that comes or goes on, from 1; belief: before it; worker: whose it is, "" until one
    was named; advised: whether a belief is kept of this worker and decides. If not, belief is that in a newcomer.
    """

    def __init__(self, scenario: Scenario, settings: PolicySettings, session: str, off: Iterable[str] = ()) -> None:
        """off: the workers who wanted no belief about them before."""
        self.scenario, self.settings, self.session = scenario, settings, session
        self._off = set(off)
        self.cycle, self.worker, self.advised = 1, "", "" not in self._off
        self.belief = self._newcomer()
        self._others: dict[str, tuple[Belief, bool]] = {}
        self._past: deque[_Past] = deque(maxlen=LATE_CYCLES)

    def take(self, event: Input, after: Belief | None = None) -> bool:
        """Go on by one input, which must fit (see `recent`); the belief after it, if that is known already.

        Whether the model holds what was seen of a cycle impossible, also if it was told late.
        """
        match event:
            case Observed() | Skipped() if event.cycle < self.cycle:
                return self._correct(event)
            case Observed() | Skipped():
                self._past.append(_Past(self.cycle, self.belief))
                self.cycle += 1
            case Advice():
                if event.on != self.advised:
                    self._switch(event.on)
                return False
            case WorkerChanged():
                self._change(event)
                return False
        if self._past:
            self._past[-1].inputs.append(event)
        if self.advised:
            self.belief = self.after(self.belief, event) if after is None else after
        return isinstance(event, Observed) and self.advised and self.belief.surprised

    def recent(self, cycle: int) -> Observed | Skipped | None:
        """How a cycle ended, if that may still be corrected."""
        for past in self._past:
            if past.cycle == cycle:
                ended = past.inputs[0]
                assert isinstance(ended, Observed | Skipped)
                return ended
        return None

    def before(self, cycle: int) -> Belief | None:
        """The belief before the cycle going on, or one that may still be corrected."""
        if cycle == self.cycle:
            return self.belief
        return next((past.belief for past in self._past if past.cycle == cycle), None)

    def after(self, belief: Belief, event: Input) -> Belief:
        """The belief after the end of a cycle or a pause."""
        match event:
            case Rested():
                return belief.rest(event.seconds)
            case Skipped():
                return belief.rest(event.duration_s)
            case Observed():
                rng = random_stream(0, "live", self.session, self.worker, event.cycle)
                if event.idle_s:
                    belief = belief.rest(event.idle_s)
                action = belief.model.actions.index(event.executed)
                return belief.weigh(action, self.likelihood(event), rng, duration_s=event.duration_s)
        raise AssertionError(event)

    def likelihood(self, event: Observed) -> Vector:
        """How likely what was seen of a cycle is under every reaction, (U,)."""
        model = self.scenario.model
        if event.likelihood is not None:
            return np.array([event.likelihood.get(name, 0.0) for name in model.outcomes])
        if event.observation == UNCLEAR and UNCLEAR not in model.observations:
            return np.ones(len(model.outcomes))
        if event.observation is not None:
            matrix = recognition_of(model.arrays, model.actions.index(event.executed))
            return np.asarray(model.arrays.observation[matrix, :, model.observations.index(event.observation)])
        return np.ones(len(model.outcomes))

    def is_off(self, worker: str) -> bool:
        """Whether a worker wants no belief about him."""
        return worker in self._off

    @property
    def planned_s(self) -> float:
        """The planned duration of a cycle."""
        assert self.scenario.model.timing is not None
        return self.scenario.model.timing.cycle_s

    def digest(self) -> str:
        """SHA-256 of where the shift stands."""
        digest = hashlib.sha256(f"{self.cycle} {self.worker} {self.advised}".encode())
        for belief in (self.belief, *(self._others[name][0] for name in sorted(self._others))):
            digest.update(belief.states.tobytes() + belief.weights.tobytes())
        return digest.hexdigest()

    def _newcomer(self) -> Belief:
        rng = random_stream(0, "live", self.session, self.worker)
        return self.scenario.initial_belief(self.settings.knows, self.scenario.model, rng)

    def _change(self, event: WorkerChanged) -> None:
        self._others[self.worker] = self.belief, self.advised
        self.worker = event.worker
        self._past.clear()
        if event.away_s is None or event.worker not in self._others:
            self._others.pop(event.worker, None)
            self.belief, self.advised = self._newcomer(), event.worker not in self._off
        else:
            belief, self.advised = self._others.pop(event.worker)
            self.belief = belief.rest(event.away_s) if self.advised else belief

    def _switch(self, on: bool) -> None:
        """Forget what was believed and seen of this worker, but not what the robot did: it may be said again."""
        self.advised, self.belief = on, self._newcomer()
        (self._off.discard if on else self._off.add)(self.worker)
        for number, past in enumerate(self._past):
            ended = past.inputs[0]
            kept = ended.without_worker() if isinstance(ended, Observed) else ended
            self._past[number] = _Past(past.cycle, self.belief, [kept])

    def _correct(self, event: Observed | Skipped) -> bool:
        """Derive the belief anew from the cycle on that is now known; whether what is known of that surprises."""
        past = list(self._past)
        first = next(number for number, one in enumerate(past) if one.cycle == event.cycle)
        belief, surprised = past[first].belief, False
        for number in range(first, len(past)):
            inputs = [event, *past[first].inputs[1:]] if number == first else past[number].inputs
            past[number] = replace(past[number], belief=belief, inputs=inputs)
            for one in inputs:
                belief = self.after(belief, one)
                surprised = belief.surprised if one is event else surprised
        self._past = deque(past, LATE_CYCLES)
        self.belief = belief
        return surprised


def _known_beforehand(policy: Policy, belief: Belief) -> Counts | None:
    """The actions of a policy whose choices nothing that is observed can change; else None."""
    if policy.draws_at_random:
        return None
    try:
        return policy.ahead(belief, MAX_CYCLES, random_stream(0, "live"))
    except NotImplementedError:
        return None

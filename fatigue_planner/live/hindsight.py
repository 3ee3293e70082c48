"""What other plans would have come to in a shift that is over: replayed with the same worker and the same chance.

Workers are drawn from what was believed of this one in the end. Each lives through the shift as it was: the actions
that the robot did, reactions drawn from what was seen, the same pauses and durations. Then he lives through it again
under another plan. In every cycle the chance by which he chose is the same: of the draws u in [0, 1) that make him
react as he did (by the order of the reactions in the experiment, with Eq. 4's probabilities), one is kept, and decides
what he does under the other plan; where the model rules out what he did, he does the same. So the plan that was
followed comes to itself, and differences are those of the plans, not of luck (common random numbers; a counterfactual
of a structural model in Pearl's sense).

It rests on the model: on its fatigue law, on Eq. 4, and on the order of the reactions, which no data can tell. What was
seen later of a cycle that was not seen is not used to guess what happened in it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import FatplanError
from fatigue_planner.core.jit import compiled
from fatigue_planner.core.random_streams import Vector, random_stream
from fatigue_planner.live.course import Stretch
from fatigue_planner.live.events import Observed, Rested, Skipped, WorkerChanged
from fatigue_planner.live.shift import Shift
from fatigue_planner.planners.schedules.policy import best_schedule_for
from fatigue_planner.planners.schedules.search import LONGEST
from fatigue_planner.pomdp.beliefs.belief import Array
from fatigue_planner.pomdp.fatigue_pomdp import FatigueArrays, FatiguePomdp, preference_probabilities, react
from fatigue_planner.pomdp.scenario import Knowledge, Scenario
from fatigue_planner.pomdp.timing import AS_PLANNED

SAMPLES = 200

Numbers = NDArray[np.intp]


@dataclass(frozen=True)
class Plan:
    """A plan by name; actions repeat from the first cycle of the shift."""

    name: str
    actions: tuple[int, ...]


@dataclass(frozen=True)
class Hindsight:
    """Costs (Eq. 5) of every sampled worker, summed over his cycles, (S,): as it was, and under the other plans."""

    cycles: int
    followed: Vector
    others: dict[str, Vector]

    def saving(self, plan: str) -> tuple[float, float, float]:
        """What was followed saved of a plan's cost, as a fraction: by means, and the middle 90 % of the workers.

        Of nothing nothing is saved; minus infinity: it cost something, and the plan would have cost nothing.
        """
        other = self.others[plan]
        shares = _saved(self.followed, other)
        # between infinite values nothing can be interpolated
        low, high = np.quantile(shares, [0.05, 0.95], method="linear" if np.isfinite(shares).all() else "nearest")
        (mean,) = _saved(self.followed.mean(keepdims=True), other.mean(keepdims=True))
        return float(mean), float(low), float(high)


def _saved(followed: Vector, other: Vector) -> Vector:
    """Of other costs (n,), the fraction that was saved; see `Hindsight.saving`."""
    nothing = np.where(followed > 0, -np.inf, 0.0)
    return np.where(other > 0, 1 - followed / np.where(other > 0, other, 1.0), nothing)


def hindsight(stretches: Sequence[Stretch], shift: Shift, plans: Sequence[Plan]) -> Hindsight:
    """The costs of the stretches of one worker as they were, and as they would have been under other plans."""
    costs = {plan.name: np.zeros(SAMPLES) for plan in plans}
    followed = np.zeros(SAMPLES)
    cycles = 0
    for number, stretch in enumerate(stretches):
        rng = random_stream(0, "hindsight", shift.session, stretch.worker, number)
        lives = [_Life.begin(shift.scenario, stretch, rng)]
        lives += [lives[0].copy() for _ in plans]
        for step in stretch.steps:
            event = step.event
            if isinstance(event, Observed):
                cycles += 1
                actual = lives[0].model.actions.index(event.executed)
                chance = lives[0].live_as_seen(event, actual, shift.likelihood(event), rng, followed)
                for life, plan in zip(lives[1:], plans, strict=True):
                    action = plan.actions[(event.cycle - 1) % len(plan.actions)]
                    life.live_by(event, action, chance, costs[plan.name])
                continue
            if seconds := _rest_s(event):
                for life in lives:
                    life.rest(seconds)
    return Hindsight(cycles, followed, costs)


def _rest_s(event: object) -> float:
    match event:
        case Rested(seconds=seconds) | Skipped(duration_s=seconds):
            return seconds
        case WorkerChanged(away_s=float(seconds)):
            return seconds
    return 0.0


@dataclass(frozen=True)
class _Chance:
    """The draws from [0, 1) by which workers (S,) reacted; or the reaction where the model rules it out, else -1."""

    draws: Vector
    ruled_out: Numbers


@dataclass
class _Life:
    """Sampled workers (S,) in the states (S, L) where a plan has brought them."""

    model: FatiguePomdp
    states: Array
    lived: dict[float, FatigueArrays]  # by share of the planned duration

    @classmethod
    def begin(cls, scenario: Scenario, stretch: Stretch, rng: np.random.Generator) -> "_Life":
        """Before the first cycle: workers as believed in the end, starts as the scenario has them."""
        model = scenario.model
        states = scenario.states[rng.choice(len(scenario.weights), SAMPLES, p=scenario.weights)].copy()
        known, belief = stretch.belief.model, stretch.belief
        assert isinstance(known, FatiguePomdp)
        if len(known.workers.expertise) > 1:
            chosen = belief.states[rng.choice(len(belief.weights), SAMPLES, p=belief.weights), -1].astype(np.intp)
            model = model.for_workers(known.workers.pick(chosen))
            states[:, -1] = np.arange(SAMPLES)
        return cls(model, states, {1.0: model.arrays})

    def copy(self) -> "_Life":
        """Another life of the same workers."""
        return _Life(self.model, self.states.copy(), self.lived)

    def rest(self, seconds: float) -> None:
        """A pause."""
        self.states = self.model.rested(self.states, seconds)

    def live_as_seen(
        self, event: Observed, action: int, likelihood: Vector, rng: np.random.Generator, costs: Vector
    ) -> _Chance:
        """A cycle with reactions drawn from what was seen; what led to them."""
        self.rest(event.idle_s)
        chances = self._chances(action)
        seen = chances * likelihood
        total = seen.sum(axis=1, keepdims=True)
        seen = np.where(total > 0, seen / np.where(total > 0, total, 1.0), likelihood / likelihood.sum())
        reactions = _drawn(seen, rng.random(SAMPLES))
        ends = np.cumsum(np.column_stack([np.zeros(SAMPLES), chances]), axis=1)
        begin, end = (ends[np.arange(SAMPLES), reactions + one] for one in (0, 1))
        within = rng.random(SAMPLES)
        self._move(event, action, reactions, costs)
        draws = np.minimum(begin + (end - begin) * within, np.nextafter(end, 0.0))
        return _Chance(draws, np.where(end > begin, -1, reactions))

    def live_by(self, event: Observed, action: int, chance: _Chance, costs: Vector) -> None:
        """A cycle with another action, and the same chance."""
        self.rest(event.idle_s)
        reactions = _drawn(self._chances(action), chance.draws)
        self._move(event, action, np.where(chance.ruled_out < 0, reactions, chance.ruled_out), costs)

    def _chances(self, action: int) -> Array:
        """Eq. 4: of each reaction, (S, U)."""
        chances = np.empty((SAMPLES, len(self.model.outcomes)))
        _choose(self.model.arrays, self.states, action, chances)
        return chances

    def _move(self, event: Observed, action: int, reactions: Numbers, costs: Vector) -> None:
        """Take the states through the cycle as long as it lasted, and add what it costs."""
        pace = self.model.pace(event.duration_s) if event.duration_s is not None else AS_PLANNED
        if pace.share not in self.lived:
            self.lived[pace.share] = self.model.evidence_arrays(pace.share).lived
        _live(self.lived[pace.share], self.states, action, reactions, costs)
        if pace.rest_s > 0:
            self.rest(pace.rest_s)


@compiled
def _choose(arrays: FatigueArrays, states: Array, action: int, chances: Array) -> None:
    """Write the chances (S, U) of the reactions to an action in states (S, L)."""
    for i in range(states.shape[0]):
        preference_probabilities(arrays, states[i], action, chances[i])


@compiled
def _live(arrays: FatigueArrays, states: Array, action: int, reactions: Numbers, costs: Vector) -> None:
    """Take states (S, L) through a cycle with reactions (S,), and add what it costs."""
    for i in range(states.shape[0]):
        costs[i] -= react(arrays, states[i], action, reactions[i])


def _drawn(chances: Array, uniforms: Vector) -> Numbers:
    """Which of the outcomes (S, U) each uniform draw leads to."""
    passed = (np.cumsum(chances, axis=1) <= uniforms[:, None]).sum(axis=1)
    return np.asarray(np.minimum(passed, chances.shape[1] - 1), np.intp)


def usual_plans(scenario: Scenario, knows: Knowledge) -> list[Plan]:
    """What would have been done without a belief, chosen before the shift: the best schedule, the best fixed action.

    None where schedules have no cost, as without a discount or with a cost that is no quadratic.
    """
    belief = scenario.initial_belief(knows, scenario.model, random_stream(0, "live"))
    try:
        return [
            Plan("the best schedule", tuple(best_schedule_for(belief, LONGEST).actions)),
            Plan("the best fixed action", tuple(best_schedule_for(belief, 1).actions)),
        ]
    except FatplanError:
        return []

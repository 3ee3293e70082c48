"""What is believed of the workers of a shift, from beginning to end: the journal's inputs, replayed."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fatigue_planner.core.random_streams import Vector
from fatigue_planner.live.doses import LivedCycle, reaction_chances
from fatigue_planner.live.events import Advice, Observed, Rested, Skipped, WorkerChanged
from fatigue_planner.live.record import Segment, Step
from fatigue_planner.live.rules import from_json
from fatigue_planner.live.shift import Shift
from fatigue_planner.live.state import LOWER, UPPER
from fatigue_planner.planners.registry import policy
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.scenario import Scenario


@dataclass
class Stretch:
    """A worker's time from when nothing was believed of him: cycles, rests and times away, in order.

    belief: in the end; chances: by cycle, how likely each reaction was, (U,).
    """

    worker: str
    steps: list[Step]
    chances: dict[int, Vector]
    belief: Belief

    def lived(self, model: FatiguePomdp, since_s: float) -> Iterator[LivedCycle]:
        """The cycles, as doses are computed from, whose hours are counted from a moment since the journal began."""
        for step in self.steps:
            if isinstance(step.event, Observed):
                action = model.actions.index(step.event.executed)
                yield LivedCycle(step.at_s - since_s, action, self.chances[step.event.cycle], step.event.duration_s)


@dataclass(frozen=True)
class Believed:
    """The fatigue of a worker's active entries after a step: means and limits of 90 % intervals, each (E,)."""

    worker: str
    at_s: float
    cycle: int
    surprised: bool
    mean: Vector
    low: Vector
    high: Vector


@dataclass(frozen=True)
class Replayed:
    """A segment: what was believed after every step of a worker about whom something may be, and the stretches."""

    believed: list[Believed]
    stretches: list[Stretch]
    digest: str


def replayed(segment: Segment, scenario: Scenario) -> Replayed:
    """The beliefs of a segment, whose scenario must be the one given; what was told late counts from its place on."""
    opened = segment.opened
    shift = Shift(scenario, policy(from_json(opened.policy)), opened.session, opened.off)
    believed: list[Believed] = []
    going: dict[str, Stretch] = {}
    ended: list[Stretch] = []
    for step in segment.steps:
        event, before, cycle = step.event, shift.belief, shift.cycle
        if isinstance(event, Advice | WorkerChanged):
            worker = event.worker if isinstance(event, WorkerChanged) else shift.worker
            begins_anew = event.on != shift.advised if isinstance(event, Advice) else event.away_s is None
            if begins_anew and worker in going:
                ended.append(going.pop(worker))
        shift.take(event)
        if not shift.advised:
            continue
        stretch = going.setdefault(shift.worker, Stretch(shift.worker, [], {}, shift.belief))
        if isinstance(event, Observed):
            before = before.rest(event.idle_s) if event.idle_s else before
            action = before.model.actions.index(event.executed)
            stretch.chances[event.cycle] = reaction_chances(before, action, shift.likelihood(event))
        stretch.steps.append(step)
        stretch.belief = shift.belief
        if isinstance(event, Observed | Skipped | Rested):
            surprised = isinstance(event, Observed) and shift.belief.surprised
            believed.append(_believed(shift, step.at_s, cycle, surprised))
    return Replayed(believed, [*ended, *going.values()], shift.digest())


def _believed(shift: Shift, at_s: float, cycle: int, surprised: bool) -> Believed:
    model, belief = shift.belief.model, shift.belief
    assert isinstance(model, FatiguePomdp)
    fatigue = belief.states[:, : model.active_entries.size].clip(0, 1)
    low, high = intervals(fatigue, belief.weights)
    return Believed(shift.worker, at_s, cycle, surprised, belief.weights @ fatigue, low, high)


def intervals(values: Array, weights: Vector) -> tuple[Vector, Vector]:
    """The smallest and the largest of the values (n, E) between the quantiles LOWER and UPPER, by column."""
    order = np.argsort(values, axis=0, kind="stable")
    reached = np.cumsum(weights[order], axis=0)
    ranked = np.take_along_axis(values, order, axis=0)
    low = (reached < LOWER).sum(axis=0)
    high = np.minimum((reached < UPPER * reached[-1]).sum(axis=0), len(values) - 1)
    columns = np.arange(values.shape[1])
    return ranked[low, columns], ranked[high, columns]

"""What a session shows to people: where the shift stands, how sure that is, and what did not go as planned."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fatigue_planner.core.random_streams import Vector
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.live.doses import Doses
from fatigue_planner.live.events import CameLate, Decided, Event, Fallback, Observed, Refused, WorkerChanged
from fatigue_planner.live.pauses import JointLevel, Levels, Passing
from fatigue_planner.live.shift import Shift
from fatigue_planner.live.watch import Alarm, Watch
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

Robot = Literal["unknown", "answers", "unreachable"]
# The joints that are shown are the most tired ones, each with an interval that holds nine tenths of the belief.
SHOWN_JOINTS = 8
LOWER, UPPER = 0.05, 0.95
# After so many cycles in a row of which nothing was seen, people should look why.
DEGRADED_AFTER = 3
DEVIATIONS = 1.645  # of a normal distribution, to either side of the mean, hold as much


@dataclass
class Counts:
    """What did not go as planned since the shift began, in cycles; contradicted: observations; refused: requests.

    late: decided later than the deadline; came_late: answers that came to their client later, as it says itself.
    """

    unseen: int = 0
    unseen_in_a_row: int = 0
    late: int = 0
    came_late: int = 0
    fallback: int = 0
    other_actions: int = 0
    surprised: int = 0
    contradicted: int = 0
    refused: int = 0

    def decide(self, event: Decided) -> None:
        """Count a decision."""
        self.late += event.late
        self.fallback += event.fallback != "none"

    def add(self, event: Event, decided: str | None, ended: int) -> None:
        """Count an event; decided: the action that was decided for the cycle, if one was; ended: the last cycle."""
        match event:
            case Observed() if not event.late:
                self.unseen += event.is_blind
                self.unseen_in_a_row = self.unseen_in_a_row + 1 if event.is_blind else 0
                self.other_actions += decided is not None and event.executed != decided
            case Observed():
                self.unseen -= not event.is_blind
                if not event.is_blind:
                    self.unseen_in_a_row = min(self.unseen_in_a_row, ended - event.cycle)
            case WorkerChanged():
                self.unseen_in_a_row = 0
            case CameLate():
                self.came_late += 1
            case Refused():
                self.refused += sum(event.counts.values())
            case _:
                self.contradicted += event.kind == "contradicted"


@dataclass(frozen=True)
class JointFatigue:
    """What is believed of the fatigue of an entry: its mean, and an interval that holds 90 % of the belief."""

    entry: str
    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class JointDose:
    """The load dose of an entry in the worker's last hour, in s (see `doses`), and a 90 % interval."""

    entry: str
    mean_s: float
    low_s: float
    high_s: float


@dataclass(frozen=True)
class Pauses:
    """What speaks for a pause, and what pauses do not change.

    wanted_s: the pause that clears all alarms; 0: none is on; None: no pause is long enough. coming: what will pass the
    limit at the present plan, if nothing more were seen. work_design: what no action keeps below it. doses: the
    largest. half_life_s: in which at least half of all fatigue fades at rest.
    """

    limit: float
    limit_source: str
    wanted_s: float | None
    alarms: tuple[Alarm, ...]
    coming: tuple[Passing, ...]
    work_design: tuple[JointLevel, ...]
    doses: tuple[JointDose, ...]
    half_life_s: float


@dataclass(frozen=True)
class SessionState:
    """Where a shift stands.

    cycle: that comes or goes on; action: what was decided for it, None before that. since_s: seconds since the last
    cycle or pause ended; planned_s: the duration of a cycle. joints: the most tired ones. fault: why nothing is
    recorded any more. worker: a random number. robot: whether it says what it does (`Session.executed`), unknown where
    it never has. rehearsal: time is simulated. degraded: nothing was seen of the
    last DEGRADED_AFTER cycles. surprises: among this worker's last `judged` cycles of which something was
    seen, late or not; fits: whether the model fits him, see `fit`.
    resumed_at: the number of the event with which the program went on; what had this or a later number before is lost.
    actions, reactions: all that can be decided and recognised, in the experiment's order; preferences: those whose
    likelihood may be said. executed: the action that the robot says it does in this cycle; None: it has not said.
    """

    cycle: int
    action: str | None
    fallback: Fallback
    since_s: float
    worker: str
    advised: bool
    counts: Counts
    planned_s: float
    joints: tuple[JointFatigue, ...]
    pauses: Pauses
    recorded: int
    durable_up_to: int
    fault: str
    robot: Robot = "unknown"
    rehearsal: bool = False
    resumed_at: int = -1
    actions: tuple[str, ...] = ()
    reactions: tuple[str, ...] = ()
    degraded: bool = False
    surprises: int = 0
    judged: int = 0
    fits: bool = True
    preferences: tuple[str, ...] = ()
    executed: str | None = None


def pauses(watch: Watch, levels: Levels, shift: Shift, now_s: float) -> Pauses:
    """What speaks for a pause now; nothing of a worker who wants no belief about him."""
    alarms = watch.alarms.now()
    lengths = [one.pause_s for one in alarms]
    settings = watch.alarms.settings
    return Pauses(
        limit=settings.limit,
        limit_source=settings.limit_source,
        wanted_s=None if None in lengths else max((one for one in lengths if one is not None), default=0.0),
        alarms=alarms,
        coming=watch.coming(shift.cycle) if shift.advised else (),
        work_design=levels.work_design if shift.advised else (),
        doses=joint_doses(watch.last_hour(shift.worker, now_s)) if shift.advised else (),
        half_life_s=watch.half_life_s,
    )


def joint_doses(doses: Doses) -> tuple[JointDose, ...]:
    """The largest doses of one period, the largest first."""
    if not len(doses.mean_s):
        return ()
    mean, reach = doses.mean_s[0], DEVIATIONS * doses.deviation_s[0]
    low, high = np.maximum(mean - reach, 0), mean + reach
    return tuple(
        JointDose(doses.entries[number], float(mean[number]), float(low[number]), float(high[number]))
        for number in np.argsort(-mean, kind="stable")[:SHOWN_JOINTS]
        if mean[number] > 0
    )


def joint_fatigue(belief: Belief) -> tuple[JointFatigue, ...]:
    """What is believed of the most tired entries, the most tired one first."""
    model = belief.model
    if not isinstance(model, FatiguePomdp):
        return ()
    # a set that was thinned keeps means and variances, at the price of states slightly outside what can be
    fatigue = belief.states[:, : model.active_entries.size].clip(0, 1)
    means = belief.weights @ fatigue
    return tuple(
        JointFatigue(
            ENTRIES[model.active_entries[number]],
            float(means[number]),
            *interval(fatigue[:, number], belief.weights),
        )
        for number in np.argsort(-means, kind="stable")[:SHOWN_JOINTS]
        if means[number] > 0
    )


def interval(values: Vector, weights: Vector) -> tuple[float, float]:
    """The smallest and the largest of the values (n,) between the quantiles LOWER and UPPER."""
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weights[order])
    low, high = np.searchsorted(reached, (LOWER, UPPER * reached[-1]))
    return float(values[order[low]]), float(values[order[min(high, values.size - 1)]])

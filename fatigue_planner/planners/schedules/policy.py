"""Policies that follow a schedule, and the best schedule for a belief, which is searched once."""

import hashlib
import time
from abc import abstractmethod
from collections.abc import Iterator
from typing import Any

import numpy as np

from fatigue_planner.core.errors import SelectionError, listed
from fatigue_planner.planners.policy import Counts, Decision, Policy, plain_decision
from fatigue_planner.planners.schedules.cost import schedule_cost
from fatigue_planner.planners.schedules.search import Plan, Schedule, best_schedule
from fatigue_planner.pomdp.beliefs.belief import Belief

# How many of the schedules found last are remembered: every run of a cell asks for the same one.
MAX_REMEMBERED = 256
_found: dict[bytes, Schedule] = {}


class SchedulePolicy(Policy):
    """Follows the schedule that is chosen in the first cycle, whatever is observed."""

    def __init__(self) -> None:
        self._plan: Plan = ()
        self._cycle = 0

    @abstractmethod
    def schedule(self, belief: Belief) -> Plan:
        """The actions to repeat, from the belief before the first cycle."""

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act."""
        begin = time.perf_counter()
        if not self._plan:
            self._plan = self.schedule(belief)
        place = self._cycle % len(self._plan)
        self._cycle += 1
        actions = belief.model.actions
        reason = f"place {place + 1} of {len(self._plan)} in the schedule {listed(actions[a] for a in self._plan)}"
        unknown = np.full(len(actions), np.nan)
        return plain_decision(self._plan[place], unknown, 0, time.perf_counter() - begin, reason, belief)

    def ahead(self, belief: Belief, n_cycles: int, rng: np.random.Generator) -> Counts:
        """See Policy.ahead."""
        plan = np.array(self._plan or self.schedule(belief))
        return plan[(self._cycle + np.arange(n_cycles)) % plan.size]


def numbers_of(names: tuple[str, ...], belief: Belief) -> Plan:
    """The numbers of these actions. Raises SelectionError for names that are no actions of the problem."""
    actions = belief.model.actions
    if unknown := [name for name in names if name not in actions]:
        raise SelectionError(f"{listed(unknown)}: not among the actions {listed(actions)}.")
    return tuple(actions.index(name) for name in names)


def best_schedule_for(belief: Belief, longest: int) -> Schedule:
    """The best schedule from a belief on, remembered for as long as it is one of the last that were asked for."""
    key = _key(belief, longest)
    if key not in _found:
        if len(_found) >= MAX_REMEMBERED:
            del _found[next(iter(_found))]
        _found[key] = best_schedule(schedule_cost(belief), len(belief.model.actions), longest)
    return _found[key]


def _key(belief: Belief, longest: int) -> bytes:
    """Digest of all that decides the best schedule."""
    model = belief.model
    digest = hashlib.sha256(repr((model.actions, len(model.outcomes), model.discount, longest)).encode())
    digest.update(repr(model.dynamics).encode())
    for part in (*_leaves(model.arrays), belief.states, belief.weights):
        table = np.ascontiguousarray(part)
        digest.update(repr(table.shape).encode() + table.tobytes())
    return digest.digest()


def _leaves(part: Any) -> Iterator[Any]:
    """The arrays and numbers of a tuple, and of the tuples in it."""
    if isinstance(part, tuple):
        for inner in part:
            yield from _leaves(inner)
    else:
        yield part

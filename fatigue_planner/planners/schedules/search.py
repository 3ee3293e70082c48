"""The best schedule: all of them where they are few, else local search over schedules of any number of actions."""

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.planners.schedules.cost import ScheduleCost, Schedules
from fatigue_planner.pomdp.cyclic_plans import repeats_no_shorter

# The longest schedule: more lines than these nobody keeps in mind.
LONGEST = 8
# All schedules of a length are listed where they are no more than these.
MAX_LISTED = 1000
# Where the search begins, besides the best of the listed ones: some of the best actions, some schedules at random.
SINGLE_STARTS = 3
RANDOM_STARTS = 12
# How many of the schedules that look best at first are looked at closely.
CLOSE = 12
# A schedule is better only if it costs less than this part less; shorter ones come first.
ROUNDING = 1e-12

Plan = tuple[int, ...]


@dataclass(frozen=True)
class Schedule:
    """Actions in order, repeated for ever.

    cost: expected, discounted. exact: all schedules that are no longer than allowed were looked at.
    """

    actions: Plan
    cost: float
    exact: bool


def best_schedule(cost: ScheduleCost, n_actions: int, longest: int = LONGEST) -> Schedule:
    """The schedule of at most `longest` cycles that costs least; found by search where there are too many to list.

    The search is steepest descent over schedules (replace, insert, remove, exchange or rotate) from several starts; it
    draws its random starts from a stream of its own, so that equal tasks have equal schedules.
    """
    judged: dict[Plan, float] = {}
    listed, exact = _listed(n_actions, longest)
    for length, plans in listed.items():
        _judge(cost, plans, judged, everything=length == 1)
    if not exact:
        for start in _starts(judged, n_actions, longest):
            _descend(cost, start, n_actions, longest, judged)
    best = _first_best(judged)
    return Schedule(best, judged[best], exact)


def _listed(n_actions: int, longest: int) -> tuple[dict[int, list[Plan]], bool]:
    """By length, all schedules that repeat no shorter one, as far as they are few; whether these are all."""
    found: dict[int, list[Plan]] = {}
    for length in range(1, longest + 1):
        if length > 1 and n_actions**length > MAX_LISTED:
            return found, False
        found[length] = [
            plan for plan in itertools.product(range(n_actions), repeat=length) if repeats_no_shorter(plan)
        ]
    return found, True


def _judge(cost: ScheduleCost, plans: Iterable[Plan], judged: dict[Plan, float], everything: bool = False) -> None:
    """Note the costs of those plans, of one length, that look best; of all if that is as easy."""
    new = [plan for plan in plans if plan not in judged]
    if not new:
        return
    few = cost.few()
    if few is not cost and not everything and len(new) > CLOSE:
        rough = few.costs(_table(new))
        new = [new[index] for index in np.argsort(rough, kind="stable")[:CLOSE]]
    judged |= zip(new, cost.costs(_table(new)).tolist(), strict=True)


def _table(plans: list[Plan]) -> Schedules:
    return np.array(plans, dtype=np.intp)


def _starts(judged: dict[Plan, float], n_actions: int, longest: int) -> Iterator[Plan]:
    """The best of every length that was listed, some single actions, and some schedules at random."""
    by_length: dict[int, list[Plan]] = {}
    for plan in sorted(judged, key=lambda plan: judged[plan]):
        by_length.setdefault(len(plan), []).append(plan)
    yield from by_length[1][:SINGLE_STARTS]
    yield from (plans[0] for length, plans in by_length.items() if length > 1)
    rng = random_stream(0, "schedule starts", n_actions, longest)
    for _ in range(RANDOM_STARTS if longest > 1 else 0):
        yield tuple(rng.integers(n_actions, size=rng.integers(2, longest + 1)).tolist())


def _descend(cost: ScheduleCost, start: Plan, n_actions: int, longest: int, judged: dict[Plan, float]) -> None:
    """Go to the best neighbour for as long as there is a better one; `judged` gets the costs of all that were seen."""
    here = start
    _judge(cost, [here], judged)
    while True:
        around = _neighbours(here, n_actions, longest)
        for plans in around.values():
            _judge(cost, plans, judged)
        near = {plan: judged[plan] for plans in around.values() for plan in plans if plan in judged}
        if not near or (best := _first_best(near)) == here or not _better(near[best], judged[here]):
            return
        here = best


def _neighbours(plan: Plan, n_actions: int, longest: int) -> dict[int, list[Plan]]:
    """The schedules one change away, by length."""
    length, actions = len(plan), range(n_actions)
    found: set[Plan] = {(*plan[:i], a, *plan[i + 1 :]) for i in range(length) for a in actions}
    found |= {plan[i:] + plan[:i] for i in range(1, length)}
    for i, j in itertools.combinations(range(length), 2):
        found.add((*plan[:i], plan[j], *plan[i + 1 : j], plan[i], *plan[j + 1 :]))
    if length < longest:
        found |= {(*plan[:i], a, *plan[i:]) for i in range(length + 1) for a in actions}
    if length > 1:
        found |= {plan[:i] + plan[i + 1 :] for i in range(length)}
    found.discard(plan)
    by_length: dict[int, list[Plan]] = {}
    for neighbour in sorted(found):
        if repeats_no_shorter(neighbour):
            by_length.setdefault(len(neighbour), []).append(neighbour)
    return by_length


def _better(cost: float, other: float) -> bool:
    return cost < other - ROUNDING * abs(other)


def _first_best(judged: dict[Plan, float]) -> Plan:
    """The cheapest schedule; of those that cost the same, the shortest, then the first."""
    least = min(judged.values())
    same = [plan for plan, cost in judged.items() if not _better(least, cost)]
    return min(same, key=lambda plan: (len(plan), plan))

"""Load doses of a shift: the integral of the load above the threshold, per joint, direction and hour.

Fatigue under the laws here fades within minutes and says nothing of a day; doses add up. A load is a fraction of the
worker's strength, it counts while it is above the experiment's `fatigue.threshold` (for the paper's 0.1 of tau_max,
section IV-B), and a dose is in s: 60 s are a minute at full strength, or ten at a tenth. No limit of a dose is known,
so none is given. Three assumptions:

- A cycle counts in the hour in which it ends.
- A cycle that was shorter than planned loads as much per second, a longer one ends with rest (`pomdp.timing`).
- Which reaction it was is only as certain as what was seen of it; the errors of different cycles are independent.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import specialised
from fatigue_planner.core.random_streams import Vector
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.problem import outcome_probabilities

Array = NDArray[np.float64]

HOUR_S = 3600.0


@dataclass(frozen=True)
class LivedCycle:
    """A cycle that a worker has worked.

    ended_s: when it ended, in s since the moment from which hours are counted; action: that the robot did; chances
    (U,): of each reaction, see `reaction_chances`; duration_s: None: as planned.
    """

    ended_s: float
    action: int
    chances: Vector
    duration_s: float | None = None


@dataclass(frozen=True)
class Doses:
    """Doses in s by hour and entry, (H, n): their means, and standard deviations for what was not seen for certain.

    entries (n,): names, those that some reaction loads at all.
    """

    entries: tuple[str, ...]
    mean_s: Array
    deviation_s: Array


def doses(model: FatiguePomdp, cycles: Iterable[LivedCycle], period_s: float = HOUR_S) -> Doses:
    """The doses of cycles, by hours (or other periods) from the first to the last in which one ended."""
    cycles = list(cycles)
    loaded, of_reaction = _loads_s(model)
    if not cycles:
        nothing = np.zeros((0, loaded.size))
        return Doses(tuple(ENTRIES[entry] for entry in loaded), nothing, nothing)
    share = np.array([model.pace(cycle.duration_s).share for cycle in cycles])
    load_s = share[:, None, None] * of_reaction[[cycle.action for cycle in cycles]]  # (N, U, n)
    chances = np.array([cycle.chances for cycle in cycles])
    mean = np.einsum("cu,cun->cn", chances, load_s)
    variance = np.einsum("cu,cun->cn", chances, np.square(load_s - mean[:, None]))
    period = np.array([int(cycle.ended_s // period_s) for cycle in cycles])
    sums = np.zeros((period.max() + 1, 2, loaded.size))
    np.add.at(sums, period, np.stack([mean, variance], axis=1))
    return Doses(tuple(ENTRIES[entry] for entry in loaded), sums[:, 0], np.sqrt(sums[:, 1]))


class RecentDoses:
    """What a worker did in the last hour, by the numbers of the cycles."""

    def __init__(self) -> None:
        self._cycles: dict[int, LivedCycle] = {}

    def add(self, number: int, cycle: LivedCycle) -> None:
        """Another cycle; or one that was told late, in place of what it was taken for."""
        before = self._cycles.get(number)
        self._cycles[number] = cycle if before is None else replace(cycle, ended_s=before.ended_s)
        self._forget(cycle.ended_s - HOUR_S)

    def last_hour(self, model: FatiguePomdp, now_s: float) -> Doses:
        """The doses of the hour before now, as one."""
        self._forget(now_s - HOUR_S)
        return doses(model, [replace(one, ended_s=0.0) for one in self._cycles.values()])

    def _forget(self, until_s: float) -> None:
        while self._cycles and next(iter(self._cycles.values())).ended_s <= until_s:
            del self._cycles[next(iter(self._cycles))]


def reaction_chances(before: Belief, action: int, likelihood: Vector) -> Vector:
    """How likely each reaction of a cycle was, (U,), by Bayes' rule: from the belief before it and what was seen.

    likelihood (U,): of what was seen; see `Belief.weigh`. Where the belief rules out what was seen, that decides alone.
    """
    model = before.model
    assert isinstance(model, FatiguePomdp)
    chances = likelihood.copy()
    if not model.arrays.even:
        chances *= expected_chances(before, action)
        chances = chances if chances.any() else likelihood
    return np.asarray(chances / chances.sum())


def expected_chances(belief: Belief, action: int) -> Vector:
    """How likely the worker is to react in each way to an action, (U,)."""
    model = belief.model
    chances = np.zeros(len(model.outcomes))
    kernel = specialised(add_chances, outcome_probabilities=model.parts["outcome_probabilities"])
    kernel(model.arrays, belief.states, belief.weights, action, chances)
    return chances


def add_chances(arrays: object, states: Array, weights: Vector, action: int, chances: Vector) -> None:
    """Template: add to `chances` (U,) the probability of every outcome of an action."""
    probabilities = np.empty(chances.size)
    for i in range(weights.size):
        outcome_probabilities(arrays, states[i], action, probabilities)
        for outcome in range(chances.size):
            chances[outcome] += weights[i] * probabilities[outcome]


def _loads_s(model: FatiguePomdp) -> tuple[NDArray[np.intp], Array]:
    """The entries that some reaction loads (n,), and how much every reaction does (A, U, n)."""
    of_reaction = np.array([[profile.load_s for profile in row] for row in model.profiles])
    loaded = np.flatnonzero(of_reaction.any(axis=(0, 1)))
    return loaded, of_reaction[:, :, loaded]

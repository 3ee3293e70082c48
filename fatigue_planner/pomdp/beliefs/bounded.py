"""How an exact set of states stays bounded where reactions are not seen: equal ones are merged, too many are thinned.

Thinning keeps some of the weighted states at random such that every expected weight is what it was, heavy ones for
certain (Fearnhead & Clifford 2003), in the order of workers and of their fatigue, so that what is kept is spread evenly
(systematic sampling). Every worker keeps his probability. Where nothing that is planned or seen depends on more than
the first two moments of every entry (novices; see `moments`), these are restored, so that no plan loses anything; then
fatigue may leave [0, 1] by a fraction of its spread.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.pomdp.beliefs.belief import Array
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.problem import Pomdp, Vector

# Fatigue is a fraction of the strength: nobody can tell such states apart.
EQUAL_FATIGUE = 1e-6
# The most states, or two per worker where that is more.
MAX_STATES = 1000
# A worker keeps at least so many states, where there is room.
MIN_PER_WORKER = 4


def bounded(model: Pomdp, states: Array, weights: Vector, rng: np.random.Generator) -> tuple[Array, Vector]:
    """The states (m, L) and weights (m,) of a belief with at most MAX_STATES states, in their order if all are kept."""
    states, weights = merged(states, weights, EQUAL_FATIGUE if isinstance(model, FatiguePomdp) else 0.0)
    if len(weights) <= MAX_STATES:
        return states, weights
    if not isinstance(model, FatiguePomdp):
        kept, share = thinned(weights, np.zeros(len(weights), np.intp), MAX_STATES, rng)
        return states[kept], share
    order = np.lexsort((states[:, :-1].sum(axis=1), states[:, -1]))
    states, weights = states[order], weights[order]
    used, worker = np.unique(states[:, -1], return_inverse=True)
    kept, share = thinned(weights, worker, max(MAX_STATES, 2 * used.size), rng)
    fewer = states[kept]
    if model.arrays.even and model.cost.is_quadratic:
        restore_moments(fewer, share, worker[kept], states, weights, worker)
    return fewer, share


def merged(states: Array, weights: Vector, tolerance: float) -> tuple[Array, Vector]:
    """States whose numbers differ by less than `tolerance` (0: not at all) as one, their mean; weights sum to 1.

    Neighbours across a multiple of the tolerance stay apart.
    """
    cells = np.floor(states / tolerance).astype(np.int64) if tolerance else (states + 0.0).view(np.int64)
    mark = cells @ _odd_numbers(states.shape[1])  # whole numbers that wrap around: a hash
    _, first, group = np.unique(mark, return_index=True, return_inverse=True)
    if first.size == len(states) or not (cells == cells[first[group]]).all():
        return states, weights / weights.sum()
    place = np.argsort(np.argsort(first))[group]  # in the order in which groups begin
    begin = np.sort(first)
    total = np.bincount(place, weights)
    together = states[begin]
    if tolerance:
        order = np.argsort(place, kind="stable")
        starts = np.searchsorted(place[order], np.arange(begin.size))
        excess = weights[order, None] * (states[order] - together[place[order]])
        together = together + np.add.reduceat(excess, starts) / total[:, None]
    return together, total / total.sum()


@cache
def _odd_numbers(count: int) -> NDArray[np.int64]:
    return np.random.default_rng(1).integers(1, 2**62, count) * 2 + 1


def thinned(
    weights: Vector, worker: NDArray[np.intp], limit: int, rng: np.random.Generator
) -> tuple[NDArray[np.intp], Vector]:
    """Which of the states are kept, about `limit` of them, and their weights; `worker` (n,): whose they are, sorted."""
    of_worker = np.bincount(worker, weights)
    least = min(MIN_PER_WORKER, limit / (2 * of_worker.size)) / limit
    chances = weights * np.maximum(1, least / of_worker)[worker]
    # c such that the sum of min(1, c w) is the limit
    falling = np.sort(chances)[::-1]
    rest, room = np.cumsum(falling[::-1])[::-1], limit - np.arange(falling.size)
    first = int(np.argmax(falling * room < rest))
    chances = np.minimum(1.0, chances * (room[first] / rest[first]))
    drawn = np.floor(np.cumsum(np.where(chances < 1, chances, 0.0)) + rng.random())
    kept = np.flatnonzero((chances == 1) | (np.diff(drawn, prepend=0.0) > 0))
    share = weights[kept] / chances[kept]
    share *= (of_worker / np.maximum(np.bincount(worker[kept], share, of_worker.size), 1e-300))[worker[kept]]
    return kept, share / share.sum()


def restore_moments(
    fewer: Array, share: Vector, kept_of: NDArray[np.intp], states: Array, weights: Vector, worker: NDArray[np.intp]
) -> None:
    """Move and stretch every worker's fatigue in `fewer` (m, L) to the means and deviations it had in all states."""
    for number in range(int(worker[-1]) + 1):
        all_of, some = worker == number, kept_of == number
        mean, deviation = moments(states[all_of, :-1], weights[all_of])
        now, spread = moments(fewer[some, :-1], share[some])
        stretch = np.where(spread > 0, deviation / np.where(spread > 0, spread, 1.0), 1.0)
        fewer[some, :-1] = mean + stretch * (fewer[some, :-1] - now)


def moments(fatigue: Array, weights: Vector) -> tuple[Vector, Vector]:
    """Mean and standard deviation of every entry."""
    share = weights / weights.sum()
    mean = share @ fatigue
    return mean, np.sqrt(share @ np.square(fatigue - mean))

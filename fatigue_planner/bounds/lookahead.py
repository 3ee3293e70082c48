"""Forward in time: the exact tree of the first cycles."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.bounds.task import Task

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Level:
    """One cycle of the tree: probability and cost (N, A, U) of the reactions to its N histories."""

    probability: Array
    cost: Array


@dataclass(frozen=True)
class Lookahead:
    """Every history of the first cycles, without reactions of probability 0; one level per cycle.

    states (N, L) and classes (N,): where the histories end, and the class they then are of.
    """

    levels: tuple[Level, ...]
    states: Array
    classes: NDArray[np.intp]

    def cost(self, leaf_cost: Vector, discount: float) -> float:
        """Least expected discounted cost from the start, given that of every leaf (N,)."""
        value = leaf_cost
        for level in reversed(self.levels):
            after = np.zeros_like(level.cost)
            after[level.probability > 0] = value
            value = (level.probability * (level.cost + discount * after)).sum(axis=-1).min(axis=-1)
        return float(value[0])


def look_ahead(task: Task, n_cycles: int, memory: int, leaves: int) -> Lookahead:
    """As many cycles as have no more than `leaves` histories; at least `memory`, at most `n_cycles`."""
    states, classes = task.start[None], np.zeros(1, dtype=np.intp)
    latest = np.arange(task.branches).reshape(task.gain.shape[:2])
    levels: list[Level] = []
    while len(levels) < n_cycles:
        after = task.gain * states[:, None, None] + task.offset
        cost = np.square(after) @ task.cost_weight
        probability = task.choice(cost)
        kept = probability > 0
        if len(levels) >= memory and np.count_nonzero(kept) > leaves:
            break
        levels.append(Level(probability, cost))
        states = after[kept]
        classes = ((classes[:, None, None] * task.branches + latest) % task.branches**memory)[kept]
    return Lookahead(tuple(levels), states, classes)

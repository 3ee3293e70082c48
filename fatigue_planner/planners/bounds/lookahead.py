"""Forward in time: the exact tree of the first cycles."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.bounds.task import Task

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


# Above this expertise rounding errors of costs, some 1e-17, affect the choice; costs are of order 1e-3.
DECISIVE = 1e6
TOO_CLOSE = 1e-12


@dataclass(frozen=True)
class Level:
    """One cycle of the tree, for N histories.

    cost (N, A, U): expected cost of the cycle where the action is taken and the reaction happens, times the
    probability of the history and the reaction. kept (N, A, U): whether that can happen.
    """

    cost: Array
    kept: NDArray[np.bool_]


@dataclass(frozen=True)
class Lookahead:
    """Every history of the first cycles that can happen, one level per cycle, and the N at the end.

    states (N, S, L): the state after the history from each of S initial states; weights (N, S): probability
    of that initial state and of the history's reactions; classes (N,): the history's last reactions.
    """

    levels: tuple[Level, ...]
    states: Array
    weights: Array
    classes: NDArray[np.intp]

    def cost(self, leaf_cost: Vector, discount: float) -> float:
        """Least expected discounted cost, given that after every history (N,), times its probability."""
        value = leaf_cost
        for level in reversed(self.levels):
            later = np.zeros_like(level.cost)
            later[level.kept] = value
            value = (level.cost + discount * later).sum(axis=-1).min(axis=-1)
        return float(value[0])


def look_ahead(tasks: Sequence[Task], weights: Vector, n_cycles: int, memory: int, leaves: int) -> Lookahead:
    """As many cycles as end in no more than `leaves` states; at least `memory`, at most `n_cycles`.

    It ends, even before `memory`, where an expert's choice is too close to call: which of two equal costs is
    the smaller one depends on the order of a sum.

    tasks, weights (S,): the same problem from every initial state, and their probabilities. The action
    depends on the history alone, so it is the same for all of them.
    """
    task = tasks[0]
    actions, reactions, _ = task.gain.shape
    states, probability = np.array([[task.start for task in tasks]]), weights[None]
    classes = np.zeros(1, dtype=np.intp)
    latest = np.arange(actions * reactions).reshape(actions, reactions)
    levels: list[Level] = []
    while len(levels) < n_cycles:
        after = task.gain[:, :, None] * states[:, None, None] + task.offset[:, :, None]
        cost = np.moveaxis(np.square(after) @ task.cost_weight, -1, 1) + task.posture_cost
        if task.expertise > DECISIVE and (np.sort(cost)[..., 1:2] - cost.min(axis=-1, keepdims=True) < TOO_CLOSE).any():
            break
        factors = task.factors_after(classes) if levels else task.factors[:1]
        joint = probability[:, :, None, None] * task.choice(cost, factors[:, None, None])
        kept = np.any(joint > 0, axis=1)
        if len(levels) >= memory and np.count_nonzero(kept) * len(tasks) > leaves:
            break
        levels.append(Level((joint * cost).sum(axis=1), kept))
        states, probability = after[kept], np.moveaxis(joint, 1, -1)[kept]
        classes = ((classes[:, None, None] * task.branches + latest) % task.branches**memory)[kept]
    return Lookahead(tuple(levels), states, probability, classes)

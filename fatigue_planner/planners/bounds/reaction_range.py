"""The extreme probabilities of the reactions in a box of states."""

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.bounds.history_classes import ClassStates
from fatigue_planner.planners.bounds.quadratics import Quadratics
from fatigue_planner.planners.bounds.task import Task

Array = NDArray[np.float64]

# Differences of costs, which are of order 1e-3, are widened by this to allow for rounding.
COST_ROUNDING = 1e-12


def reaction_extremes(task: Task, states: ClassStates) -> Array:
    """Distributions (M or 1, A, E, U) whose convex hull holds P(. | f, a) for every state f of the class.

    The distributions with low_u <= P(u) <= high_u (`probability_ranges`) form a polytope. Its vertices
    are found by raising the probabilities from `low`, in each order of the reactions, as far as `high`
    and the sum 1 allow. A novice has a single distribution.
    """
    actions, reactions, _ = task.gain.shape
    if task.expertise == 0:
        return np.full((1, actions, 1, reactions), 1 / reactions)
    low, high = probability_ranges(task, states)
    vertices = []
    for order in permutations(range(reactions)):
        vertex = low.copy()
        for u in order:
            vertex[..., u] += np.clip(1 - vertex.sum(axis=-1), 0, high[..., u] - low[..., u])
        vertices.append(vertex)
    return np.stack(vertices, axis=-2)


def probability_ranges(task: Task, states: ClassStates) -> tuple[Array, Array]:
    """Least and greatest P(u | f, a), both (M, A, U), over the states f of every class; expertise > 0.

    Eq. 4 is P(u) = 1 / (1 + sum over the others v of exp(-beta (c_v - c_u))), and the minimum of
    c_v - c_u over the box has a closed form.
    """
    after = task.gain * states.typical[:, None, None] + task.offset
    cost = Quadratics(
        np.square(after) @ task.cost_weight + task.posture_cost,
        2 * task.cost_weight * task.gain * after,
        np.broadcast_to(task.cost_weight * np.square(task.gain), after.shape),
    )
    reactions = range(task.gain.shape[1])
    box = states.low[:, None, None], states.high[:, None, None]
    low, high = np.empty_like(cost.value), np.empty_like(cost.value)
    for u in reactions:
        own, others = cost[:, :, [u]], cost[:, :, [v for v in reactions if v != u]]
        least = (others - own).minimum(*box) - COST_ROUNDING
        most = COST_ROUNDING - (own - others).minimum(*box)
        with np.errstate(over="ignore"):
            low[..., u] = 1 / (1 + np.exp(-task.expertise * least).sum(axis=-1))
            high[..., u] = 1 / (1 + np.exp(-task.expertise * most).sum(axis=-1))
    return low, high

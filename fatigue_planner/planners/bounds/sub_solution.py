"""Backward in time: the quadratics V_t of `cost_bound`, one per class of histories."""

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.bounds.quadratics import Quadratics, joined, zero
from fatigue_planner.planners.bounds.task import ClassStates, HistoryClasses, Task

Array = NDArray[np.float64]

# Differences of costs, which are of order 1e-3, are widened by this to allow for rounding.
COST_ROUNDING = 1e-12
# The weights of a mean move towards a function by these steps; the best is kept.
STEPS = np.arange(1, 9) / 8
# How many classes are computed at a time: few enough for the processor's cache.
BLOCK = 512
# A spread counts as at least this much, so that no curvature is so large that rounding matters.
MIN_SPREAD = 1e-3


@dataclass(frozen=True)
class Transition:
    """A class's states before and after a cycle, and the class (M, R) that each reaction leads to."""

    now: ClassStates
    then: ClassStates
    successors: NDArray[np.intp]


def cost_to_go(task: Task, classes: HistoryClasses, begin: int, end: int) -> Quadratics:
    """V_t at t = begin of every class (M,), where V_t = 0 at t = end."""
    size = len(classes.successors)
    blocks = [slice(first, first + BLOCK) for first in range(0, size, BLOCK)]
    later = zero(size, task.start.size)
    then = classes.states(end)
    for time in range(end - 1, begin - 1, -1):
        now = classes.states(time)
        later = joined(
            [
                below_all(behaviours(task, Transition(now[b], then, classes.successors[b]), later), now[b])
                for b in blocks
            ]
        )
        then = now
    return later


def behaviours(task: Task, transition: Transition, later: Quadratics) -> Quadratics:
    """The right side of (1), one function of the state before for each case of action and extreme reaction (M, F)."""
    actions, reactions, _ = task.gain.shape
    size = len(transition.successors)
    each = after_reactions(task, transition, later).reshape(size, actions, 1, reactions)
    return each.mean(reaction_extremes(task, transition.now)).reshape(size, -1)


def after_reactions(task: Task, transition: Transition, later: Quadratics) -> Quadratics:
    """C(f') + gamma V_t+1(f') of every reaction (M, R), as a function of the state f before it.

    With d = f - typical, f' = gain typical + offset + gain d lies e + gain d from what is typical then.
    """
    gain, offset = task.reactions()
    weight, discount = task.cost_weight, task.discount
    after = gain * transition.now.typical[:, None] + offset
    e = after - transition.then.typical[transition.successors]
    future = later[transition.successors]
    return Quadratics(
        np.square(after) @ weight + task.posture_cost.ravel() + discount * future.at(e),
        gain * (2 * weight * after + discount * (future.slope + 2 * future.curvature * e)),
        np.square(gain) * (weight + discount * future.curvature),
    )


def below_all(functions: Quadratics, states: ClassStates) -> Quadratics:
    """One function (M,) that in the box of its class lies below all of F functions (M, F).

    Slopes and curvatures are those of `bent_mean`. The weights start on the first function and move
    towards each of the others as far as that raises the mean of the result over the typical spread.
    """

    def candidate(weights: Array) -> Quadratics:
        return lowered(bent_mean(functions, weights, states.spread), functions, states)

    weights = np.zeros_like(functions.value)
    weights[:, 0] = 1
    merit = _typical_mean(candidate(weights), states)
    for towards in np.eye(weights.shape[1])[1:]:
        origin = weights
        for step in STEPS:
            moved = (1 - step) * origin + step * towards
            moved_merit = _typical_mean(candidate(moved), states)
            weights = np.where((moved_merit > merit)[:, None], moved, weights)
            merit = np.maximum(moved_merit, merit)
    return candidate(weights)


def bent_mean(functions: Quadratics, weights: Array, spread: Array) -> Quadratics:
    """The mean (M,) of the functions (M, F) with these weights (M, F), every entry bent down by kappa.

    kappa = (weighted standard deviation of the functions' slopes) / (2 spread) minimises what is lost: by the
    slopes that differ, deviation^2 / (4 kappa), and by the bending, kappa spread^2.
    """
    mean = functions.mean(weights)
    deviation = np.sqrt(np.einsum("mf,mfl->ml", weights, np.square(functions.slope - mean.slope[:, None])))
    return Quadratics(mean.value, mean.slope, mean.curvature - deviation / (2 * np.maximum(spread, MIN_SPREAD)))


def lowered(shape: Quadratics, functions: Quadratics, states: ClassStates) -> Quadratics:
    """The functions `shape` (M,), moved up or down until they lie below all `functions` (M, F) in their box."""
    excess = (functions - shape[:, None]).minimum(states.low[:, None], states.high[:, None]).min(axis=-1)
    return Quadratics(shape.value + excess, shape.slope, shape.curvature)


def _typical_mean(function: Quadratics, states: ClassStates) -> Array:
    """Mean (M,) over states of the class's typical mean and spread."""
    return np.asarray(function.value + (function.curvature * np.square(states.spread)).sum(axis=-1))


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

"""Backward in time: the quadratics V_t of `cost_bound`, one per class of histories."""

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled
from fatigue_planner.planners.bounds.quadratics import Quadratics, joined, zero
from fatigue_planner.planners.bounds.task import ClassStates, HistoryClasses, Task
from fatigue_planner.pomdp.simd import LANES, sum_in_lanes

Array = NDArray[np.float64]

# Differences of costs, which are of order 1e-3, are widened by this to allow for rounding.
COST_ROUNDING = 1e-12
# The weights of a mean move towards a function by these steps; the best is kept.
STEPS = tuple(i / 8 for i in range(1, 9))
# How many classes are computed at a time: few enough for the processor's cache.
BLOCK = 512
# A spread counts as at least this much, so that no curvature is so large that rounding matters.
MIN_SPREAD = 1e-3


@dataclass(frozen=True)
class Transition:
    """A class's states before and after a cycle, and the class (M, R) that each reaction leads to.

    factors (M, K, U): what the factors of Eq. 4 may be.
    """

    now: ClassStates
    then: ClassStates
    successors: NDArray[np.intp]
    factors: Array


def cost_to_go(task: Task, classes: HistoryClasses, begin: int, end: int) -> Quadratics:
    """V_t at t = begin of every class (M,), where V_t = 0 at t = end."""
    size = len(classes.successors)
    blocks = [slice(first, first + BLOCK) for first in range(0, size, BLOCK)]
    later = zero(size, task.start.size)
    then = classes.states(end)
    factors = task.factors_after(np.arange(size))[:, None] if classes.memory > 0 else task.factors[None]
    for time in range(end - 1, begin - 1, -1):
        now = classes.states(time)
        later = joined(
            [
                below_all(behaviours(task, Transition(now[b], then, classes.successors[b], factors[b]), later), now[b])
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
    return each.mean(reaction_extremes(task, transition.now, transition.factors)).reshape(size, -1)


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
    """One function (M,) that in the box of its class lies below all of F functions (M, F); see `fill_below`."""
    size, length = states.spread.shape
    missing = (0, -length % LANES)
    slope, curvature = (
        np.pad(np.broadcast_to(table, (*functions.value.shape, length)), ((0, 0), (0, 0), missing))
        for table in (functions.slope, functions.curvature)
    )
    low, high, spread = (np.pad(table, ((0, 0), missing)) for table in (states.low, states.high, states.spread))
    best = np.empty(size), np.empty(low.shape), np.empty(low.shape)
    fill_below(functions.value, slope, curvature, low, high, spread, *best)
    return Quadratics(best[0], best[1][:, :length].copy(), best[2][:, :length].copy())


@compiled
def fill_below(  # noqa: PLR0912 - loops over entries, which become vector code
    value: Array,
    slope: Array,
    curvature: Array,
    low: Array,
    high: Array,
    spread: Array,
    best_value: Array,
    best_slope: Array,
    best_curvature: Array,
) -> None:
    """Fill in one function (M,) that lies below all of F functions (M, F) of L entries in the box low ... high (M, L).

    Its shape is a weighted mean of the functions, every entry bent down by kappa = (weighted standard deviation of the
    functions' slopes) / (2 spread). That minimises what is lost: by the slopes that differ, deviation^2 / (4 kappa),
    and by the bending, kappa spread^2. It is moved up or down until it lies below all functions.

    The weights start on the first function and move towards each of the others as far as that raises the mean of the
    result over the typical spread. Whatever does not is noticed at the first function that is too low for it, mostly
    the one that was the lowest before.
    """
    count, width = slope.shape[1:]
    terms, lanes, variance, moved_variance, best_variance = (
        np.empty(width), np.empty(LANES), np.empty(width), np.empty(width), np.empty(width),
    )  # fmt: skip
    mean_slope, mean_curvature, moved_slope, moved_curvature, bent = (
        np.empty(width), np.empty(width), np.empty(width), np.empty(width), np.empty(width),
    )  # fmt: skip
    chosen_slope, chosen_curvature = np.empty(width), np.empty(width)
    for m in range(value.shape[0]):
        lowest, merit, chosen_value = 0, -np.inf, value[m, 0]
        for j in range(width):
            chosen_slope[j], chosen_curvature[j], best_variance[j] = slope[m, 0, j], curvature[m, 0, j], 0.0
        for towards in range(count):
            mean_value = chosen_value
            for j in range(width):
                mean_slope[j], mean_curvature[j], variance[j] = chosen_slope[j], chosen_curvature[j], best_variance[j]
            for step in STEPS:
                moved_value = (1 - step) * mean_value + step * value[m, towards]
                for j in range(width):
                    apart = mean_slope[j] - slope[m, towards, j]
                    moved_slope[j] = mean_slope[j] - step * apart
                    moved_variance[j] = (1 - step) * (variance[j] + step * apart * apart)
                for j in range(width):
                    moved_curvature[j] = (1 - step) * mean_curvature[j] + step * curvature[m, towards, j]
                    bent[j] = moved_curvature[j] - np.sqrt(moved_variance[j]) / (2 * max(spread[m, j], MIN_SPREAD))
                for j in range(width):
                    terms[j] = bent[j] * spread[m, j] * spread[m, j]
                typical = sum_in_lanes(terms, lanes)
                excess = np.inf
                first = lowest
                for turn in range(count + 1):  # the one that was the lowest first
                    f = first if turn == 0 else turn - 1
                    if turn > 0 and f == first:
                        continue
                    for j in range(width):
                        a, b = curvature[m, f, j] - bent[j], slope[m, f, j] - moved_slope[j]
                        inside = min(max(-0.5 * b / (a if a > 0 else 1.0), low[m, j]), high[m, j])
                        end = low[m, j] if b + a * (low[m, j] + high[m, j]) > 0 else high[m, j]
                        d = inside if a > 0 else end
                        terms[j] = (b + a * d) * d
                    least = value[m, f] - moved_value + sum_in_lanes(terms, lanes)
                    if least < excess:
                        excess, lowest = least, f
                        if moved_value + excess + typical <= merit:
                            break
                if moved_value + excess + typical > merit:
                    merit, chosen_value = moved_value + excess + typical, moved_value
                    best_value[m] = moved_value + excess
                    for j in range(width):
                        best_slope[m, j], best_curvature[m, j] = moved_slope[j], bent[j]
                        chosen_slope[j], chosen_curvature[j] = moved_slope[j], moved_curvature[j]
                        best_variance[j] = moved_variance[j]


def reaction_extremes(task: Task, states: ClassStates, factors: Array) -> Array:
    """Distributions (M, A, E, U) whose convex hull holds P(. | f, a) for every state f of the class.

    The distributions with low_u <= P(u) <= high_u (`probability_ranges`) form a polytope. Its vertices
    are found by raising the probabilities from `low`, in each order of the reactions, as far as `high`
    and the sum 1 allow. A novice has a single distribution.
    """
    actions, reactions, _ = task.gain.shape
    if task.expertise == 0:
        chances = factors / factors.sum(axis=-1, keepdims=True)
        return np.broadcast_to(chances[:, None], (len(factors), actions, factors.shape[1], reactions))
    low, high = probability_ranges(task, states, factors)
    vertices = []
    for order in permutations(range(reactions)):
        vertex = low.copy()
        for u in order:
            vertex[..., u] += np.clip(1 - vertex.sum(axis=-1), 0, high[..., u] - low[..., u])
        vertices.append(vertex)
    return np.stack(vertices, axis=-2)


def probability_ranges(task: Task, states: ClassStates, factors: Array) -> tuple[Array, Array]:
    """Least and greatest P(u | f, a), both (M, A, U), over the states f of every class; expertise > 0.

    With factors b, any of (M, K, U), P(u) = 1 / (1 + sum over the others v of b_v / b_u exp(-beta (c_v - c_u))), and
    the minimum of c_v - c_u over the box has a closed form.
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
        rest = [v for v in reactions if v != u]
        own, others = cost[:, :, [u]], cost[:, :, rest]
        ratio = factors[..., rest] / factors[..., [u]]
        largest, smallest = ratio.max(axis=1)[:, None], ratio.min(axis=1)[:, None]
        least = (others - own).minimum(*box) - COST_ROUNDING
        most = COST_ROUNDING - (own - others).minimum(*box)
        with np.errstate(over="ignore"):
            low[..., u] = 1 / (1 + (largest * np.exp(-task.expertise * least)).sum(axis=-1))
            high[..., u] = 1 / (1 + (smallest * np.exp(-task.expertise * most)).sum(axis=-1))
    return low, high

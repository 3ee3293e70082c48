"""The exact value of plans that repeat a few actions forever, whatever is observed.

Where the worker's choices do not depend on fatigue (a novice), the expected cost of such a plan is
quadratic in every entry of the fatigue, so it is known for any state without a simulation.
"""

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.jit import compiled, inlined
from fatigue_planner.pomdp.simd import LANES, aligned, aligned_zeros, quadratic, sum_in_lanes

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# The longest plans, in cycles; those of more than one cycle only where there are at most MAX_PLANS of that length.
MAX_PLAN_LENGTH = 6
MAX_PLANS = 1000
# Where there are too many actions for that: so many of the best longer plans of a rested worker, found by extending the
# best of every length by every action, about MAX_EXTENDED of a length; each from every starting point.
PROMISING_PLANS, MAX_EXTENDED = 16, 10_000
# Stands for a curvature of 0 where it is divided by.
TINY = 1e-300
# By so many of the possible workers they are judged.
JUDGES = 4


class PlanValues(NamedTuple):
    """Plan p of worker m is worth constant[m, p] + sum over entries of (square f^2 + linear f) at [m, p]."""

    square: Array
    linear: Array
    constant: Array


def cyclic_plans(actions: int) -> list[tuple[int, ...]]:
    """All plans from every starting point, without those that only repeat a shorter one."""
    plans: list[tuple[int, ...]] = []
    for length in range(1, MAX_PLAN_LENGTH + 1):
        if length > 1 and actions**length > MAX_PLANS:
            break
        plans += [plan for plan in itertools.product(range(actions), repeat=length) if repeats_no_shorter(plan)]
    return plans


def repeats_no_shorter(plan: tuple[int, ...]) -> bool:
    """Whether a plan is not a shorter one several times."""
    length = len(plan)
    return not any(length % n == 0 and plan == plan[:n] * (length // n) for n in range(1, length))


def plan_values(moments: "MeanMaps", discount: float, entries: int) -> PlanValues:
    """The discounted returns of all cyclic plans worth considering, where all reactions are equally likely.

    Raises ExperimentError without a discount below 1.
    """
    if discount >= 1:
        raise ExperimentError("leaf value bound: endless plans have no value without a discount below 1.")
    workers, actions = moments.g.shape[:2]
    plans = cyclic_plans(actions)
    if len(plans) == actions > 1:  # too many actions to list longer plans
        plans += _promising_plans(moments, discount, entries)
    values = _values(moments, discount, entries, *in_turns(plans))
    return undominated(values, np.zeros(moments.weight.size), np.ones(moments.weight.size)) if workers == 1 else values


def in_turns(plans: list[tuple[int, ...]]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Plans (N, longest) without those that start another one elsewhere, their lengths, and the rows of all starts.

    The value of a plan from every starting point is a step of one recursion, so they are so many at the work of one.
    """
    number = {plan: index for index, plan in enumerate(plans)}
    groups = []
    for plan in plans:
        if plan in number:
            groups.append([number.pop(plan[i:] + plan[:i]) for i in range(len(plan))])
    lengths = np.array([len(group) for group in groups])
    cycles, rows = (np.full((len(groups), lengths.max()), -1) for _ in range(2))
    for index, group in enumerate(groups):
        cycles[index, : len(group)], rows[index, : len(group)] = plans[group[0]], group
    return cycles, lengths, rows


def most_plans(actions: int) -> int:
    """No more plans than this are considered."""
    listed = len(cyclic_plans(actions))
    return listed + (PROMISING_PLANS * MAX_PLAN_LENGTH if listed == actions > 1 else 0)


def _promising_plans(moments: "MeanMaps", discount: float, entries: int) -> list[tuple[int, ...]]:
    """The best plans of several actions for a rested worker, by beam search, from every starting point."""
    workers, actions = moments.g.shape[:2]
    judges = np.unique(np.linspace(0, workers - 1, JUDGES).astype(np.intp))
    few = moments.of_workers(judges)
    beam, best = np.arange(actions)[:, None], dict[tuple[int, ...], float]()
    width = max(MAX_EXTENDED // actions, 1)
    for _ in range(1, MAX_PLAN_LENGTH):
        kept = beam[np.argsort(-_rested_values(few, discount, entries, beam), kind="stable")[:width]]
        beam = np.column_stack([np.repeat(kept, actions, axis=0), np.tile(np.arange(actions), len(kept))])
        values = _rested_values(few, discount, entries, beam)
        order = np.argsort(-values, kind="stable")[: 4 * PROMISING_PLANS]
        best |= {tuple(beam[index].tolist()): float(values[index]) for index in order}
    own = [plan for plan in sorted(best, key=lambda plan: -best[plan]) if repeats_no_shorter(plan)]
    turned = [plan[i:] + plan[:i] for plan in own[:PROMISING_PLANS] for i in range(len(plan))]
    return list(dict.fromkeys(turned))


def _rested_values(moments: "MeanMaps", discount: float, entries: int, plans: NDArray[np.intp]) -> Vector:
    return np.asarray(values_of_plans(moments, discount, entries, plans).constant.mean(axis=0))


class MeanMaps(NamedTuple):
    """Means over the reactions of what a cycle, which maps f to g f + o, does and costs.

    g, gg, o, oo, go (M, A, L): of g, g^2, o, o^2 and g o; weight (L,): of each entry in the cost; posture (A,): of what
    postures add to it.
    """

    g: Array
    gg: Array
    o: Array
    oo: Array
    go: Array
    weight: Vector
    posture: Vector

    def of_workers(self, chosen: NDArray[np.intp]) -> "MeanMaps":
        """Those of some of the workers."""
        g, gg, o, oo, go = (table[chosen] for table in (self.g, self.gg, self.o, self.oo, self.go))
        return MeanMaps(g, gg, o, oo, go, self.weight, self.posture)


def mean_maps(
    gain: Array, offset: Array, weight: Vector, posture_cost: Array, chances: Vector | None = None
) -> MeanMaps:
    """The means over reactions of cycle maps (M, A, U, L) and of what postures cost (A, U).

    chances (U,): how likely every reaction is; None: all equally.
    """

    def mean(table: Array, axis: int) -> Array:
        return np.asarray(table.mean(axis) if chances is None else np.average(table, axis, chances))

    g, gg, o, oo, go = (mean(table, 2) for table in (gain, gain**2, offset, offset**2, gain * offset))
    return MeanMaps(g, gg, o, oo, go, weight, mean(posture_cost, 1))


def values_of_plans(moments: MeanMaps, discount: float, entries: int, plans: NDArray[np.intp]) -> PlanValues:
    """The discounted returns of endless cyclic plans (P, length). The discount is below 1."""
    lengths, rows = np.full(len(plans), plans.shape[1]), np.full(plans.shape, -1)
    rows[:, 0] = np.arange(len(plans))
    return _values(moments, discount, entries, plans, lengths, rows)


def _values(
    moments: MeanMaps,
    discount: float,
    entries: int,
    plans: NDArray[np.intp],
    lengths: NDArray[np.intp],
    rows: NDArray[np.intp],
) -> PlanValues:
    """See `fill_values`."""
    shape = moments.g.shape[0], int(rows.max()) + 1, moments.weight.size
    values = PlanValues(aligned_zeros(shape), aligned_zeros(shape), np.zeros(shape[:2]))
    fill_values(moments, discount, moments.weight / entries, plans, lengths, rows, values)
    return values


@compiled
def fill_values(  # noqa: PLR0912 - loops over entries, which become vector code
    moments: MeanMaps,
    discount: float,
    weight: Vector,
    plans: NDArray[np.intp],
    lengths: NDArray[np.intp],
    rows: NDArray[np.intp],
    values: PlanValues,
) -> None:
    """Fill in the values of plans (P, length), from starting point i in row rows[p, i] unless that is negative.

    With V(f) = sum_j A_j f_j^2 + B_j f_j + C after a cycle and cost sum_j w_j f_j^2 + p, before it, with means
    over the reactions f' = g f + o:
        A <- mean (gamma A - w) g^2
        B <- mean 2 (gamma A - w) g o + gamma B g
        C <- sum_j mean (gamma A - w) o^2 + gamma B o  -  mean p  +  gamma C
    Backwards through a whole plan each of A, B, C is mapped affinely to itself; the fixed point is the plan's value.
    """
    width, longest = weight.size, plans.shape[1]
    slope, shift, terms, lanes = np.empty(width), np.empty(width), np.empty(width), np.empty(LANES)
    square, linear, bent = np.empty((longest, width)), np.empty((longest, width)), np.empty((longest, width))
    added, constant = np.empty(longest), np.empty(longest)
    for m in range(moments.g.shape[0]):
        g, gg, o, oo, go = moments.g[m], moments.gg[m], moments.o[m], moments.oo[m], moments.go[m]
        for p in range(plans.shape[0]):
            length = lengths[p]
            for j in range(width):
                slope[j], shift[j] = 1.0, 0.0
            for step in range(length):  # the last cycle first
                a = plans[p, length - 1 - step]
                for j in range(width):
                    slope[j] *= discount * gg[a, j]
                    shift[j] = (discount * shift[j] - weight[j]) * gg[a, j]
            for j in range(width):
                square[0, j] = shift[j] / (1 - slope[j])
            for step in range(length):
                a = plans[p, length - 1 - step]
                for j in range(width):
                    bent[step, j] = discount * square[step, j] - weight[j]
                if step + 1 < length:
                    for j in range(width):
                        square[step + 1, j] = bent[step, j] * gg[a, j]
            for j in range(width):
                slope[j], shift[j] = 1.0, 0.0
            for step in range(length):
                a = plans[p, length - 1 - step]
                for j in range(width):
                    slope[j] *= discount * g[a, j]
                for j in range(width):
                    shift[j] = discount * g[a, j] * shift[j] + 2 * bent[step, j] * go[a, j]
            for j in range(width):
                linear[0, j] = shift[j] / (1 - slope[j])
            for step in range(length - 1):
                a = plans[p, length - 1 - step]
                for j in range(width):
                    linear[step + 1, j] = discount * g[a, j] * linear[step, j] + 2 * bent[step, j] * go[a, j]
            whole, decay = 0.0, 1.0
            for step in range(length):
                a = plans[p, length - 1 - step]
                for j in range(width):
                    terms[j] = bent[step, j] * oo[a, j] + discount * linear[step, j] * o[a, j]
                added[step] = sum_in_lanes(terms, lanes) - moments.posture[a]
                whole = discount * whole + added[step]
                decay *= discount
            constant[0] = whole / (1 - decay)
            for step in range(length - 1):
                constant[step + 1] = discount * constant[step] + added[step]
            for step in range(length):
                row = rows[p, (length - step) % length]  # from the cycle that follows this step's
                if row >= 0:
                    for j in range(width):
                        values.square[m, row, j] = square[step, j]
                    for j in range(width):
                        values.linear[m, row, j] = linear[step, j]
                    values.constant[m, row] = constant[step]


def undominated(values: PlanValues, low: Vector, high: Vector) -> PlanValues:
    """One worker's plans without those which for no fatigue between `low` and `high` (W,) are better than another.

    The difference of two plans' values is a sum over the entries of a quadratic in each, so its maximum
    is the sum of their maxima. What is never better for a fatigue is not for the mean over several, either.
    """
    square, linear, constant = values.square[0], values.linear[0], values.constant[0]
    middle = (low + high) / 2
    order = np.argsort(-(constant + ((square * middle + linear) * middle).sum(axis=1)), kind="stable")
    kept = np.ones(constant.size, dtype=bool)
    leave_out(PlanValues(square, linear, constant), low, high, order, kept)
    return PlanValues(aligned(values.square[:, kept]), aligned(values.linear[:, kept]), values.constant[:, kept])


@compiled
def leave_out(values: PlanValues, low: Vector, high: Vector, order: NDArray[np.intp], kept: NDArray[np.bool_]) -> None:
    """Unmark in `kept` (P,) the dominated ones of plans (P, W); those that come first in `order` stay."""
    terms, lanes = np.empty(low.size), np.empty(LANES)
    for better in order:
        if not kept[better]:
            continue
        for rival in range(kept.size):
            if rival == better or not kept[rival]:
                continue
            for j in range(low.size):
                a = values.square[rival, j] - values.square[better, j]
                b = values.linear[rival, j] - values.linear[better, j]
                top = min(max(-0.5 * b / min(a, -TINY), low[j]), high[j])  # where it is greatest if a < 0
                terms[j] = max((a * low[j] + b) * low[j], (a * high[j] + b) * high[j], (a * top + b) * top)
            if values.constant[rival] - values.constant[better] + sum_in_lanes(terms, lanes) <= 0:
                kept[rival] = False


@inlined
def best_plan_value(values: PlanValues, state: Vector) -> float:
    """The value of the best plan for a state, whose last number is the worker."""
    worker = int(state[state.size - 1])
    square, linear = values.square[worker], values.linear[worker]
    best = -np.inf
    for plan in range(square.shape[0]):
        best = max(best, values.constant[worker, plan] + quadratic(square, linear, state, plan))
    return best

"""The exact value of plans that repeat a few actions forever, whatever is observed.

Where the worker's choices do not depend on fatigue (a novice), the expected cost of such a plan is
quadratic in every entry of the fatigue, so it is known for any state without a simulation.
"""

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.jit import inlined

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# The longest plans, in cycles; those of more than one cycle only where there are at most MAX_PLANS of that length.
MAX_PLAN_LENGTH = 6
MAX_PLANS = 1000
# Where there are too many actions for that: so many of the best longer plans of a rested worker, found by extending the
# best of every length by every action, about MAX_EXTENDED of a length; each from every starting point.
PROMISING_PLANS, MAX_EXTENDED = 16, 10_000
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
    found = [
        values_of_plans(moments, discount, entries, np.array([plan for plan in plans if len(plan) == length]))
        for length in sorted({len(plan) for plan in plans})
    ]
    values = PlanValues(*(np.concatenate(parts, axis=1) for parts in zip(*found, strict=True)))
    return _undominated(values) if workers == 1 else values


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


def mean_maps(gain: Array, offset: Array, weight: Vector, posture_cost: Array) -> MeanMaps:
    """The means over equally likely reactions of cycle maps (M, A, U, L) and of what postures cost (A, U)."""
    g, gg, o, oo, go = (table.mean(axis=2) for table in (gain, gain**2, offset, offset**2, gain * offset))
    return MeanMaps(g, gg, o, oo, go, weight, posture_cost.mean(axis=1))


def values_of_plans(moments: MeanMaps, discount: float, entries: int, plans: NDArray[np.intp]) -> PlanValues:
    """The discounted returns of endless cyclic plans (P, length). The discount is below 1.

    With V(f) = sum_j A_j f_j^2 + B_j f_j + C after a cycle and cost sum_j w_j f_j^2 / 2N + p, before it, with means
    over the reactions f' = g f + o:
        A <- mean (gamma A - w / 2N) g^2
        B <- mean 2 (gamma A - w / 2N) g o + gamma B g
        C <- sum_j mean (gamma A - w / 2N) o^2 + gamma B o  -  mean p  +  gamma C
    Backwards through a whole plan each of A, B, C is mapped affinely to itself; the fixed point is the plan's value.
    """
    phases, weight = plans.T[::-1], moments.weight  # the last cycle first
    square = _fixed_point([(discount * moments.gg[:, now], -moments.gg[:, now] * weight / entries) for now in phases])
    curvature = [discount * after - weight / entries for after in square]
    linear = _fixed_point(
        [(discount * moments.g[:, now], 2 * w * moments.go[:, now]) for now, w in zip(phases, curvature, strict=True)]
    )
    added = [
        (w * moments.oo[:, now] + discount * after * moments.o[:, now]).sum(axis=-1) - moments.posture[now]
        for now, w, after in zip(phases, curvature, linear, strict=True)
    ]
    constant = _fixed_point([(np.full_like(cost, discount), cost) for cost in added])
    return PlanValues(square[0], linear[0], constant[0])


def _fixed_point(steps: list[tuple[Array, Array]]) -> list[Array]:
    """x before each of the steps x <- a x + b, repeated forever: the last step ends where the first begins."""
    slope, shift = np.ones_like(steps[0][0]), np.zeros_like(steps[0][1])
    for a, b in steps:
        slope, shift = a * slope, a * shift + b
    values = [shift / (1 - slope)]
    for a, b in steps[:-1]:
        values.append(a * values[-1] + b)
    return values


def _undominated(values: PlanValues) -> PlanValues:
    """Without dominated plans, which for no fatigue in [0, 1] are better than some other plan.

    The difference of two plans' values is a sum over the entries of a quadratic in each, so its maximum
    is the sum of their maxima.
    """
    square, linear, constant = values.square[0], values.linear[0], values.constant[0]
    undominated = np.ones(constant.size, dtype=bool)
    for better in np.argsort(-constant):
        if undominated[better]:
            a, b, c = square - square[better], linear - linear[better], constant - constant[better]
            with np.errstate(divide="ignore", invalid="ignore"):
                top = np.clip(-b / (2 * a), 0, 1)
            middle = np.where(a < 0, (a * top + b) * top, 0.0)
            dominated = np.maximum(np.maximum(a + b, 0), middle).sum(axis=1) + c <= 0
            dominated[better] = False
            undominated &= ~dominated
    return PlanValues(*(table[:, undominated] for table in values))


@inlined
def best_plan_value(values: PlanValues, state: Vector) -> float:
    """The value of the best plan for a state, whose last number is the worker.

    The sum is kept in four parts that do not wait for each other (`simd.LANES`).
    """
    worker = int(state[state.size - 1])
    square, linear = values.square[worker], values.linear[worker]
    best = -np.inf
    for plan in range(square.shape[0]):
        s0 = s1 = s2 = s3 = 0.0
        for j in range(0, square.shape[1], 4):
            s0 += (square[plan, j] * state[j] + linear[plan, j]) * state[j]
            s1 += (square[plan, j + 1] * state[j + 1] + linear[plan, j + 1]) * state[j + 1]
            s2 += (square[plan, j + 2] * state[j + 2] + linear[plan, j + 2]) * state[j + 2]
            s3 += (square[plan, j + 3] * state[j + 3] + linear[plan, j + 3]) * state[j + 3]
        best = max(best, values.constant[worker, plan] + ((s0 + s1) + (s2 + s3)))
    return best

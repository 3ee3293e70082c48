"""The exact value of plans that repeat a few actions for ever, whatever is observed.

Where the worker's choices do not depend on fatigue (a novice), the expected cost of such a plan is
quadratic in every entry of the fatigue, so it is known at once for any state.
"""

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.compiled import compiled

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# Plans of up to so many cycles; with many actions, only as long as there are at most MOST_PLANS of them.
LONGEST_PLAN = 4
MOST_PLANS = 1000
# Backward steps until the discount has made the rest negligible.
NEGLIGIBLE = 1e-12
MOST_STEPS = 2000


class PlanValues(NamedTuple):
    """Plan p of worker m is worth constant[m, p] + sum over entries of (square f^2 + linear f) at [m, p]."""

    square: Array
    linear: Array
    constant: Array


def cyclic_plans(actions: int) -> list[tuple[int, ...]]:
    """All plans from every starting point, without those that only repeat a shorter one."""
    plans: list[tuple[int, ...]] = []
    for length in range(1, LONGEST_PLAN + 1):
        longer = [
            plan
            for plan in itertools.product(range(actions), repeat=length)
            if not any(length % n == 0 and plan == plan[:n] * (length // n) for n in range(1, length))
        ]
        if length > 1 and len(plans) + len(longer) > MOST_PLANS:
            break
        plans += longer
    return plans


def plan_values(gain: Array, offset: Array, discount: float, entries: int) -> PlanValues:
    """The discounted returns of all cyclic plans, reactions being equally likely.

    gain, offset (M, A, U, L): cycle maps. With V(f) = sum_j A_j f_j^2 + B_j f_j + C after a cycle and cost
    sum_j f_j^2 / 2N, before it, with means over the reactions f' = g f + o:
        A <- mean (gamma A - 1 / 2N) g^2
        B <- mean 2 (gamma A - 1 / 2N) g o + gamma B g
        C <- sum_j mean (gamma A - 1 / 2N) o^2 + gamma B o  +  gamma C
    repeated backwards through the plan until what lies beyond is negligible.
    """
    plans = cyclic_plans(gain.shape[1])
    steps = (
        MOST_STEPS
        if discount == 1
        else min(MOST_STEPS, int(np.log(NEGLIGIBLE) / np.log(max(discount, NEGLIGIBLE))) + 1)
    )
    square = np.zeros((gain.shape[0], len(plans), gain.shape[-1]))
    linear, constant = np.zeros_like(square), np.zeros(square.shape[:2])
    g1, g2, o1, o2, go = (table.mean(axis=2) for table in (gain, gain**2, offset, offset**2, gain * offset))
    for back in range(steps, 0, -1):
        # the action a plan takes in its cycle number back - 1
        now = np.array([plan[(back - 1) % len(plan)] for plan in plans])
        weight = discount * square - 1 / entries
        constant = (weight * o2[:, now] + discount * linear * o1[:, now]).sum(axis=2) + discount * constant
        linear = 2 * weight * go[:, now] + discount * linear * g1[:, now]
        square = weight * g2[:, now]
    return PlanValues(square, linear, constant)


@compiled
def best_plan_value(values: PlanValues, state: Vector) -> float:
    """The value of the best plan for a state, whose last number is the worker."""
    worker = int(state[state.size - 1])
    best = -np.inf
    for plan in range(values.constant.shape[1]):
        total = values.constant[worker, plan]
        for j in range(values.square.shape[2]):
            total += (values.square[worker, plan, j] * state[j] + values.linear[worker, plan, j]) * state[j]
        best = max(best, total)
    return best

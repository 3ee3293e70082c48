"""A lower bound on the cost of every policy, whatever it remembers and however long it computes.

Let J_t(f) be the least expected discounted cost of the cycles t ... n-1 from a known state f, over all
policies that see every state and every reaction: J_n = 0 and J_t(f) = min over a of T[J_t+1](f, a) with

    T[V](f, a) = sum over u of P(u | f, a) [C(f') + gamma V(f')],    f' = gain[a, u] f + offset[a, u].

Sort the histories into classes m by their last k reactions. Every state such a history can lead to lies in
a box B_t(m). Let V_n = 0 and let functions V_t(m, .) fulfil, for all m, all f in B_t(m), and with m' for m
followed by (a, u),

    V_t(m, f)  <=  min over a of T[V_t+1(m', .)](f, a).                                            (1)

Then V_t <= J_t, by induction from t = n: T does not fall when V_t+1 is replaced by the larger J_t+1, and then
the right side is J_t. So minimising exactly over the first d cycles, with V_d in place of J_d at the end
of every history, gives no more than J_0: the bound.

V_t(m, .) is a separable quadratic. Whatever its slopes and curvatures are, its constant is set to the
largest that keeps (1): the minimum over a box of separable quadratics has a closed form
(`sub_solution.fill_below`). For beta > 0 the P(u | f, a) that a box allows are replaced by all distributions
between their least and greatest values (`probability_ranges`), which can only lower the right side of (1). So
the bound needs no solver and has no tolerance: slopes chosen badly make it lower, not wrong. Only rounding
remains: sums of L terms of the size of the bound, at 2^-53 each, which over 100 cycles stay below 1e-12
of the bound. The fraction ROUNDING of it is subtracted; an expert's choice between costs that differ by no more than
rounding ends the exact cycles before it (`lookahead.look_ahead`).

Where the initial state is hidden, the first d cycles are minimised over what depends on the history of
actions and reactions only, for all initial states together. From then on every initial state has its own
V_t, as if it were revealed, which never raises a cost. The reactions of a novice (beta = 0) say nothing
about a hidden state; there every policy plays the same game from all initial states at once, and (initial
state, entry) is treated as one longer state whose costs are weighted with the belief: nothing is ever
revealed. Likewise a policy that sees the reactions with errors costs no less than one that sees them.
"""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.bounds.lookahead import look_ahead
from fatigue_planner.planners.bounds.sub_solution import cost_to_go
from fatigue_planner.planners.bounds.task import HistoryClasses, Task, class_memory, hidden_state
from fatigue_planner.pomdp.scenario import Scenario

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

ROUNDING = 1e-10  # fraction of the bound
CLASSES = 4096
LEAVES = 100_000


@dataclass(frozen=True)
class CostBound:
    """No policy's expected discounted cost is below `cost`.

    exact: `cost` is the least expected cost itself, as every history was examined.
    state_revealed: the policies it holds for may know the worker's initial state after `exact_cycles`.
    exact_cycles, memory: d and k of the module's proof. seconds: wall-clock time taken.
    """

    cost: float
    exact: bool
    state_revealed: bool
    exact_cycles: int
    memory: int
    seconds: float


def cost_lower_bound(
    gain: Array,
    offset: Array,
    expertise: float,
    states: Array,
    weights: Vector,
    discount: float,
    entries: int,
    n_cycles: int,
    classes: int = CLASSES,
    leaves: int = LEAVES,
    entry_weight: Vector | None = None,
    posture_cost: Array | None = None,
    factors: Array | None = None,
) -> CostBound:
    """Bound E[sum over t = 0 ... n_cycles - 1 of discount^t C(f_t+1)] from below, for every policy.

    gain, offset (A, U, L): the cycle map of every reaction; expertise: beta of Eq. 4, 0 to infinity;
    states (n, L), weights (n,): the initial belief; entries: 2N of Eq. 5, C(f) = sum of w f^2 / 2N + p with w =
    entry_weight (L,), in the paper 1, and p = posture_cost (A, U) of the reaction before, in the paper 0; factors
    (1 or 1 + U, U): of the Boltzmann factors, by the reaction before (see `FatigueArrays`), in the paper 1. More
    `classes` of histories, and more `leaves` in the exact tree of the first cycles, make the bound
    tighter and take more time. Raises ValueError if a gain is negative.
    """
    begin = time.perf_counter()
    if (gain < 0).any():
        raise ValueError("The bound needs gains of at least 0.")
    w = np.ones(gain.shape[2]) if entry_weight is None else entry_weight
    p = np.zeros(gain.shape[:2]) if posture_cost is None else posture_cost
    b = np.ones((1, gain.shape[1])) if factors is None else factors
    tasks, start_weights = [Task(gain, offset, s, w / entries, p, expertise, discount, b) for s in states], weights
    if expertise == 0:
        tasks, start_weights = [hidden_state(tasks[0], w, entries, states, weights)], np.ones(1)
    memory = min(class_memory(tasks[0].branches, classes), n_cycles)
    lookahead = look_ahead(tasks, start_weights, n_cycles, memory, leaves)
    if len(lookahead.levels) < memory:  # a choice too close to call; classes can remember no more
        memory = len(lookahead.levels)
        lookahead = look_ahead(tasks, start_weights, n_cycles, memory, leaves)
    depth = len(lookahead.levels)
    leaf_cost = np.zeros(len(lookahead.classes))
    for s, task in enumerate(tasks):
        histories = HistoryClasses(task, memory, n_cycles)
        displacement = lookahead.states[:, s] - histories.states(depth).typical[lookahead.classes]
        value = cost_to_go(task, histories, depth, n_cycles)[lookahead.classes].at(displacement)
        leaf_cost += lookahead.weights[:, s] * value
    return CostBound(
        cost=max(0.0, lookahead.cost(leaf_cost, discount) * (1 - ROUNDING)),
        exact=depth == n_cycles,
        state_revealed=len(tasks) > 1 and depth < n_cycles,
        exact_cycles=depth,
        memory=memory,
        seconds=time.perf_counter() - begin,
    )


def bound_of(scenario: Scenario, n_cycles: int) -> CostBound:
    """The bound of a scenario whose worker is known. Raises ExperimentError if the cost is no quadratic."""
    model = scenario.model
    model.cost.check_quadratic("the bound of the cost")
    active = model.active_entries.size
    if active == 0 and not model.posture_cost.any():  # nothing ever costs anything
        return CostBound(cost=0.0, exact=True, state_revealed=False, exact_cycles=n_cycles, memory=0, seconds=0.0)
    shape = (len(model.actions), len(model.outcomes), -1)
    return cost_lower_bound(
        model.arrays.gain.reshape(shape)[:, :, :active],
        model.arrays.offset.reshape(shape)[:, :, :active],
        float(model.workers.expertise[0]),
        scenario.states[:, :active],
        scenario.weights,
        model.discount,
        model.entries,
        n_cycles,
        entry_weight=model.arrays.cost.weight[:active],
        posture_cost=model.posture_cost,
        factors=model.arrays.factors,
    )


def fingerprint(scenario: Scenario) -> dict[str, Any]:
    """All that decides the bound of a scenario, as JSON values: neither its belief nor what is recognised."""
    model = scenario.model
    factors = model.arrays.factors.tolist()
    return {
        "shape": [len(model.actions), len(model.outcomes), model.active_entries.size, model.entries],
        "gain": model.arrays.gain.tolist(),
        "offset": model.arrays.offset.tolist(),
        "expertise": repr(float(model.workers.expertise[0])),
        "states": scenario.states.tolist(),
        "weights": scenario.weights.tolist(),
        "discount": model.discount,
        "cost": [model.cost.kind, model.arrays.cost.weight.tolist(), model.posture_cost.tolist()],
        "factors": factors,
    }

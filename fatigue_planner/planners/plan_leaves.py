"""The last cycles of a lookahead after which the robot follows one plan, the best for the whole belief.

Nobody sees the state, so a belief is worth the largest mean value of a plan, not the mean of the largest:

    V(b) = max over plans p of  sum over s of b(s) V_p(s).

Every state goes through all histories of the last cycles before the next state does: its worker's plans are read once.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined, kernel
from fatigue_planner.planners.expectimax import Levels
from fatigue_planner.planners.pomcp.buffers import SearchParameters, Workspace
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.cyclic_plans import PlanValues, undominated
from fatigue_planner.pomdp.fatigue_pomdp import (
    FatigueArrays,
    FatiguePomdp,
    preference_probabilities,
    react,
    recognition_of,
)
from fatigue_planner.pomdp.simd import LANES, aligned_zeros, quadratic

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# The last two cycles are one piece of work where that takes no more sums than this.
MAX_SUMS = 2**17
# So many states wait for the values of their worker's plans: as many as stay in the fastest memory.
WAITING = 16
# Plans are sorted out before a search with so many histories for each.
MANY_HISTORIES = 100


class PlanEnds(NamedTuple):
    """Working memory for the last one or two cycles, begun after actions and what was seen after them (B; 1 or A O).

    before (A,): rewards of the first of two cycles; gained (B, A): of the last; sums (B A O, P): the weighted values of
    plans, by history. States that wait for these: waiting (n, >= L), weights, begin, outcomes (n,), begin being that of
    a history's O sums. early (L,): the state after the first of two cycles. first, last (U,): chances.
    """

    before: Vector
    gained: Array
    sums: Array
    waiting: Array
    weights: Vector
    begin: NDArray[np.int64]
    outcomes: NDArray[np.int64]
    early: Vector
    first: Vector
    last: Vector


def new_ends(actions: int, outcomes: int, observations: int, plans: int, width: int, cycles: int) -> PlanEnds:
    """Memory for the last `cycles` cycles of states of `width` numbers."""
    begun = (actions * observations) ** (cycles - 1)
    return PlanEnds(
        np.zeros(actions if cycles > 1 else 0),
        np.zeros((begun, actions)),
        aligned_zeros((begun * actions * observations, plans)),
        aligned_zeros((WAITING, width + -width % LANES)),
        np.zeros(WAITING),
        np.zeros(WAITING, np.int64),
        np.zeros(WAITING, np.int64),
        aligned_zeros(width),
        np.zeros(outcomes),
        np.zeros(outcomes),
    )


def last_cycles_of(model: FatiguePomdp, plans: PlanValues, depth: int) -> int:
    """How many cycles of a lookahead are one piece of work."""
    histories = (len(model.actions) * len(model.observations)) ** 2
    few = histories * plans.constant.shape[1] <= MAX_SUMS
    return 2 if model.observation_reveals_outcome and depth > 1 and few else 1


def plans_in_reach(belief: Belief, plans: PlanValues, depth: int) -> PlanValues:
    """One worker's plans without those that for no fatigue in reach after `depth` cycles are the best.

    Only where there are so many histories that this is worth its while.
    """
    model = belief.model
    workers, count = plans.constant.shape
    histories = float(len(model.actions) * len(model.observations)) ** depth
    if workers > 1 or histories < MANY_HISTORIES * count:
        return plans
    return undominated(plans, *in_reach(belief, depth))


def in_reach(belief: Belief, depth: int) -> tuple[Vector, Vector]:
    """Between which levels (W,) every entry of every state lies after `depth` cycles; a gain is never negative."""
    gain, offset = belief.model.arrays.gain, belief.model.arrays.offset
    low, high = belief.states[:, :-1].min(axis=0), belief.states[:, :-1].max(axis=0)
    for _ in range(depth):
        low, high = (gain * low + offset).min(axis=0), (gain * high + offset).max(axis=0)
    return low, high


@kernel
def last_cycles_and_plans(
    arrays: FatigueArrays,
    plans: PlanValues,
    levels: Levels,
    ends: PlanEnds,
    _workspace: Workspace,
    parameters: SearchParameters,
    _rng: np.random.Generator,
) -> None:
    """See `expectimax.last_cycles`."""
    level, actions = levels.values.shape[0] - 1, levels.values.shape[1]
    observations, early = arrays.observation.shape[2], ends.early
    clear(ends)
    for i in range(levels.begin[level], levels.begin[level] + levels.size[level]):
        state, weight, waiting = levels.states[i], levels.weights[i], int(np.int64(0))  # a mere 0 is compiled anew
        if ends.before.size == 0:
            waiting = add_cycle(arrays, plans, ends, state, weight, int(np.int64(0)), waiting)
        else:
            for action in range(actions):
                preference_probabilities(arrays, state, action, ends.first)
                for outcome in range(ends.first.size):
                    if weight * ends.first[outcome] > 0:
                        for j in range(state.size):
                            early[j] = state[j]
                        reward = react(arrays, early, action, outcome)
                        ends.before[action] += weight * ends.first[outcome] * reward
                        begun = action * observations + outcome
                        waiting = add_cycle(arrays, plans, ends, early, weight * ends.first[outcome], begun, waiting)
        value_waiting(arrays, plans, ends, int(state[state.size - 1]), waiting)
    values = levels.values[level]
    for action in range(actions):
        if ends.before.size == 0:
            values[action] = value_of(ends, 0, action, observations, parameters.discount)
            continue
        values[action] = ends.before[action]
        for observation in range(observations):
            best = -np.inf
            for then in range(actions):
                begun = action * observations + observation
                best = max(best, value_of(ends, begun, then, observations, parameters.discount))
            values[action] += parameters.discount * best


@inlined
def clear(ends: PlanEnds) -> None:
    """Begin anew."""
    for action in range(ends.before.size):
        ends.before[action] = 0.0
    for begun in range(ends.gained.shape[0]):
        for action in range(ends.gained.shape[1]):
            ends.gained[begun, action] = 0.0
    for history in range(ends.sums.shape[0]):
        for plan in range(ends.sums.shape[1]):
            ends.sums[history, plan] = 0.0


@kernel
def add_cycle(
    arrays: FatigueArrays, plans: PlanValues, ends: PlanEnds, state: Vector, weight: float, begun: int, waiting: int
) -> int:
    """The last cycle from a state of this weight; how many states wait then (`waiting` do so far)."""
    observations = arrays.observation.shape[2]
    for action in range(ends.gained.shape[1]):
        preference_probabilities(arrays, state, action, ends.last)
        for outcome in range(ends.last.size):
            chance = weight * ends.last[outcome]
            if chance <= 0:
                continue
            if waiting == WAITING:
                value_waiting(arrays, plans, ends, int(state[state.size - 1]), waiting)
                waiting = int(np.int64(0))
            moved = ends.waiting[waiting, : state.size]
            for j in range(state.size):
                moved[j] = state[j]
            ends.gained[begun, action] += chance * react(arrays, moved, action, outcome)
            ends.weights[waiting], ends.outcomes[waiting] = chance, outcome
            ends.begin[waiting] = (begun * ends.gained.shape[1] + action) * observations
            waiting += 1
    return waiting


@kernel
def value_waiting(arrays: FatigueArrays, plans: PlanValues, ends: PlanEnds, worker: int, waiting: int) -> None:
    """Add to the sums what the worker's plans are worth in the states that wait."""
    square, linear, constant = plans.square[worker], plans.linear[worker], plans.constant[worker]
    for plan in range(constant.size):
        for k in range(waiting):
            value = ends.weights[k] * (constant[plan] + quadratic(square, linear, ends.waiting[k], plan))
            if arrays.observation_reveals_outcome:
                ends.sums[ends.begin[k] + ends.outcomes[k], plan] += value
            else:
                action = ends.begin[k] // arrays.observation.shape[2] % ends.gained.shape[1]
                for observation in range(arrays.observation.shape[2]):
                    seen = arrays.observation[recognition_of(arrays, action), ends.outcomes[k], observation]
                    ends.sums[ends.begin[k] + observation, plan] += seen * value


@inlined
def value_of(ends: PlanEnds, begun: int, action: int, observations: int, discount: float) -> float:
    """The value of an action in the last cycle: its reward and, after every observation, the best plan."""
    total = ends.gained[begun, action]
    for observation in range(observations):
        history = (begun * ends.gained.shape[1] + action) * observations + observation
        best = -np.inf
        for plan in range(ends.sums.shape[1]):
            best = max(best, ends.sums[history, plan])
        total += discount * best
    return float(total)

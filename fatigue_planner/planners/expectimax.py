"""The kernel of the full-width lookahead: expectimax over beliefs, every average exact.

Beliefs are not normalised along the way: the value of weighted states is homogeneous in the weights, so the
probability of an observation is the weight that remains after it.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined_for_any_problem
from fatigue_planner.planners.pomcp.buffers import SearchParameters, Workspace
from fatigue_planner.planners.pomcp.search import leaf_value
from fatigue_planner.planners.pomcp.tree import Array
from fatigue_planner.pomdp.parts import is_legal, is_terminal
from fatigue_planner.pomdp.problem import advance, expected_reward, observation_probability, outcome_probabilities
from fatigue_planner.pomdp.simd import aligned

# Whether the observation always reveals the outcome, the number of observations, and whether leaves have values.
OBSERVATION_REVEALS_OUTCOME = False
N_OBSERVATIONS = 0
LEAVES = True


class Levels(NamedTuple):
    """Working memory: level d's belief lies in rows begin[d] ... begin[d] + size[d] - 1.

    states (rows, L), weights (rows,), probabilities (rows, K); size, branch (levels,); values (levels, A).
    branch[d] counts the branches (an action, then an observation) begun at level d.
    """

    begin: NDArray[np.int64]
    size: NDArray[np.int64]
    branch: NDArray[np.int64]
    states: Array
    weights: NDArray[np.float64]
    probabilities: Array
    values: Array


def new_levels(
    states: int, width: int, levels: int, outcomes: int, actions: int, observation_reveals_outcome: bool
) -> Levels:
    """Memory for beliefs that begin with `states` states, on so many levels and, of a last cycle, the leaves.

    Beliefs grow unless observations reveal outcomes.
    """
    sizes = [states * (1 if observation_reveals_outcome else outcomes**level) for level in range(levels + 1)]
    begin = np.concatenate([[0], np.cumsum(sizes)])
    rows = int(begin[-1])
    return Levels(
        begin,
        np.zeros(levels, np.int64),
        np.zeros(levels, np.int64),
        aligned(np.empty((rows, width))),
        np.empty(rows),
        np.empty((rows, outcomes)),
        np.empty((levels, actions)),
    )


def best_return(
    arrays: Any,
    bound_arrays: Any,
    levels: Levels,
    ends: Any,
    workspace: Workspace,
    parameters: SearchParameters,
    rng: np.random.Generator,
) -> float:
    """Template: the best expected return from the weighted states of level 0, by full enumeration.

        V(b) = max over a of  sum over s, u of b(s) P(u | s, a) r(s, a, u)  +  gamma * sum over o of V(b_ao)

    with b_ao(s') = sum of b(s) P(u | s, a) P(o | s', a, u), not normalised. The last level's values are those of
    `last_cycles`. The search is depth first and leaves the actions' values in values[0].
    """
    count, actions = levels.values.shape
    observations = levels.probabilities.shape[1] if OBSERVATION_REVEALS_OUTCOME else N_OBSERVATIONS
    level = 0
    levels.branch[0] = 0
    while True:
        values = levels.values[level]
        if level + 1 == count and levels.branch[level] == 0:
            last_cycles(arrays, bound_arrays, levels, ends, workspace, parameters, rng)
            levels.branch[level] = actions * observations
        if levels.branch[level] == actions * observations:
            best = values[0]
            for action in range(1, actions):
                best = max(best, values[action])
            if level == 0:
                return float(best)
            level -= 1
            levels.values[level, (levels.branch[level] - 1) // observations] += parameters.discount * best
            continue
        action, observation = levels.branch[level] // observations, levels.branch[level] % observations
        if observation == 0 and not may(arrays, levels, level, action):
            values[action] = -np.inf
            levels.branch[level] += observations
            continue
        if observation == 0:
            values[action] = 0.0
            for i in range(levels.begin[level], levels.begin[level] + levels.size[level]):
                outcome_probabilities(arrays, levels.states[i], action, levels.probabilities[i])
        levels.branch[level] += 1
        reached, reward = observe(arrays, levels, level, action, observation)
        values[action] += reward
        if reached > 0:
            level += 1
            levels.size[level] = reached
            levels.branch[level] = 0


def last_cycles(
    arrays: Any,
    bound_arrays: Any,
    levels: Levels,
    ends: Any,
    workspace: Workspace,
    parameters: SearchParameters,
    rng: np.random.Generator,
) -> None:
    """Placeholder for the values of all actions at the last level; `ends` is its own memory."""
    raise NotImplementedError


def last_cycle(
    arrays: Any,
    bound_arrays: Any,
    levels: Levels,
    _ends: Any,
    workspace: Workspace,
    parameters: SearchParameters,
    rng: np.random.Generator,
) -> None:
    """Template: one more cycle, after which every state counts with its leaf value."""
    level, actions = levels.values.shape[0] - 1, levels.values.shape[1]
    observations = levels.probabilities.shape[1] if OBSERVATION_REVEALS_OUTCOME else N_OBSERVATIONS
    begin, below, values = levels.begin[level], levels.begin[level + 1], levels.values[level]
    for action in range(actions):
        if not may(arrays, levels, level, action):
            values[action] = -np.inf
            continue
        if not LEAVES:
            values[action] = expected_now(arrays, levels, workspace, level, action)
            continue
        values[action] = 0.0
        for i in range(begin, begin + levels.size[level]):
            outcome_probabilities(arrays, levels.states[i], action, levels.probabilities[i])
        for observation in range(observations):
            reached, reward = observe(arrays, levels, level, action, observation)
            values[action] += reward
            for row in range(below, below + reached):
                leaf = Workspace(levels.states[row], workspace.moved, workspace.probabilities, *workspace[3:])
                value = leaf_value(arrays, bound_arrays, leaf, parameters, actions, rng)
                values[action] += parameters.discount * levels.weights[row] * value


@inlined_for_any_problem
def always_may(_arrays: Any, _levels: Levels, _level: int, _action: int) -> bool:
    """The rule of a problem that forbids nothing."""
    return True


def may(arrays: Any, levels: Levels, level: int, action: int) -> bool:
    """Template: whether every state of a level's belief permits an action; a task that has ended, any."""
    for i in range(levels.begin[level], levels.begin[level] + levels.size[level]):
        if not is_terminal(arrays, levels.states[i]) and not is_legal(arrays, levels.states[i], action):
            return False
    return True


def expected_now(arrays: Any, levels: Levels, workspace: Workspace, level: int, action: int) -> float:
    """Template: the expected reward of an action in a level's belief."""
    total = 0.0
    for i in range(levels.begin[level], levels.begin[level] + levels.size[level]):
        reward = expected_reward(arrays, levels.states[i], action, levels.probabilities[i], workspace.moved)
        total += levels.weights[i] * reward
    return total


def observe(arrays: Any, levels: Levels, level: int, action: int, observation: int) -> tuple[int, float]:
    """Template: fill the belief one level below, after an action and an observation.

    Returns its size and the expected reward, weighted by how likely the observation is.
    """
    below = levels.begin[level + 1]
    reached, total = 0, 0.0
    for i in range(levels.begin[level], levels.begin[level] + levels.size[level]):
        for outcome in range(levels.probabilities.shape[1]):
            weight = levels.weights[i] * levels.probabilities[i, outcome]
            if weight <= 0 or (OBSERVATION_REVEALS_OUTCOME and outcome != observation):
                continue
            moved = levels.states[below + reached]
            for j in range(moved.size):
                moved[j] = levels.states[i, j]
            reward = advance(arrays, moved, action, outcome)
            if not OBSERVATION_REVEALS_OUTCOME:
                weight *= observation_probability(arrays, moved, action, outcome, observation)
            if weight > 0:
                total += weight * reward
                levels.weights[below + reached] = weight
                reached += 1
    return reached, total

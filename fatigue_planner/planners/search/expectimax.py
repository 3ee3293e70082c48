"""The kernel of the full-width lookahead: expectimax over beliefs, every average exact.

Beliefs are not normalised on the way: the value of weighted states is homogeneous in the weights, so the
chance of an observation is the weight that is left after it.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.search.descent import leaf_value
from fatigue_planner.planners.search.numbers import Numbers, Room
from fatigue_planner.planners.search.tree import Array
from fatigue_planner.pomdp.problem import advance, expected_reward, observation_probability, outcome_probabilities
from fatigue_planner.pomdp.vectors import aligned

# Whether the observation always tells the outcome, how many observations there are, and whether leaves have values.
TELLING = False
N_OBSERVATIONS = 0
LEAVES = True


class Levels(NamedTuple):
    """Working memory: level d's belief lies in rows begin[d] ... begin[d + 1] - 1.

    states (rows, L), weights (rows,), probabilities (rows, K); values (depth, A)
    """

    begin: NDArray[np.int64]
    states: Array
    weights: NDArray[np.float64]
    probabilities: Array
    values: Array


def new_levels(states: Array, depth: int, outcomes: int, actions: int, telling: bool) -> Levels:
    """Memory for a lookahead from a belief of states (n, L): unless the observation tells, beliefs grow."""
    sizes = [len(states) * (1 if telling else outcomes**level) for level in range(depth + 1)]
    begin = np.concatenate([[0], np.cumsum(sizes)])
    rows = int(begin[-1])
    return Levels(
        begin,
        aligned(np.empty((rows, states.shape[1]))),
        np.empty(rows),
        np.empty((rows, outcomes)),
        np.empty((depth, actions)),
    )


def best_return(  # noqa: PLR0912 - one enumeration
    arrays: Any, levels: Levels, room: Room, level: int, count: int, numbers: Numbers, rng: np.random.Generator
) -> float:
    """Template: the best expected return from the `count` weighted states of a level, by full enumeration.

        V(b) = max over a of  sum over s, u of b(s) P(u | s, a) r(s, a, u)  +  gamma * sum over o of V(b_ao)

    with b_ao(s') = sum of b(s) P(u | s, a) P(o | s', a, u), not normalised. Below the last level stands the
    leaf value of every state.
    """
    depth, actions = levels.values.shape
    first, below = levels.begin[level], levels.begin[level + 1]
    for action in range(actions):
        if not LEAVES and level + 1 == depth:
            levels.values[level, action] = 0.0
            for i in range(first, first + count):
                reward = expected_reward(arrays, levels.states[i], action, levels.probabilities[i], room.moved)
                levels.values[level, action] += levels.weights[i] * reward
            continue
        for i in range(first, first + count):
            outcome_probabilities(arrays, levels.states[i], action, levels.probabilities[i])
        total = 0.0
        for observation in range(levels.probabilities.shape[1] if TELLING else N_OBSERVATIONS):
            reached = 0
            for i in range(first, first + count):
                for outcome in range(levels.probabilities.shape[1]):
                    weight = levels.weights[i] * levels.probabilities[i, outcome]
                    if weight <= 0 or (TELLING and outcome != observation):
                        continue
                    place = below + reached
                    for j in range(room.state.size):
                        levels.states[place, j] = levels.states[i, j]
                    reward = advance(arrays, levels.states[place], action, outcome)
                    if not TELLING:
                        weight *= observation_probability(arrays, levels.states[place], action, outcome, observation)
                    if weight > 0:
                        total += weight * reward
                        levels.weights[place] = weight
                        reached += 1
            if reached > 0 and level + 1 < depth:
                total += numbers.discount * best_return(arrays, levels, room, level + 1, reached, numbers, rng)
            else:
                for place in range(below, below + reached):
                    leaf = Room(levels.states[place], room.moved, room.probabilities, *room[3:])
                    value = leaf_value(arrays, leaf, numbers, actions, rng)
                    total += numbers.discount * levels.weights[place] * value
        levels.values[level, action] = total
    best = levels.values[level, 0]
    for action in range(1, actions):
        best = max(best, levels.values[level, action])
    return float(best)

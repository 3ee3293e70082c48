"""The kernel of the full-width lookahead: expectimax over beliefs, every average exact.

Beliefs are not normalised on the way: the value of weighted states is homogeneous in the weights, so the
chance of an observation is the weight that is left after it.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.search.descent import Numbers, leaf_value
from fatigue_planner.planners.search.tree import Array
from fatigue_planner.pomdp.problem import advance, observation_probability, outcome_probabilities

# Whether the observation always tells the outcome, and how many observations there are.
TELLING = False
N_OBSERVATIONS = 0


class Room(NamedTuple):
    """Working memory: level d's belief lies in rows begin[d] ... begin[d + 1] - 1.

    states (rows, L), weights (rows,), probabilities (rows, K); values (depth, A); state, moved (L,)
    """

    begin: NDArray[np.int64]
    states: Array
    weights: NDArray[np.float64]
    probabilities: Array
    values: Array
    state: NDArray[np.float64]
    moved: NDArray[np.float64]
    scratch: NDArray[np.float64]


def room_for(states: Array, depth: int, outcomes: int, actions: int, telling: bool) -> Room:
    """Memory for a lookahead from a belief of states (n, L): unless the observation tells, beliefs grow."""
    sizes = [len(states) * (1 if telling else outcomes**level) for level in range(depth + 1)]
    begin = np.concatenate([[0], np.cumsum(sizes)])
    rows, width = int(begin[-1]), states.shape[1]
    return Room(
        begin,
        np.empty((rows, width)),
        np.empty(rows),
        np.empty((rows, outcomes)),
        np.empty((depth, actions)),
        np.empty(width),
        np.empty(width),
        np.empty(outcomes),
    )


def best_return(arrays: Any, room: Room, level: int, count: int, numbers: Numbers, rng: np.random.Generator) -> float:
    """Template: the best expected return from the `count` weighted states of a level, by full enumeration.

        V(b) = max over a of  sum over s, u of b(s) P(u | s, a) r(s, a, u)  +  gamma * sum over o of V(b_ao)

    with b_ao(s') = sum of b(s) P(u | s, a) P(o | s', a, u), not normalised. Below the last level stands the
    leaf value of every state.
    """
    depth, actions = room.values.shape
    first, below = room.begin[level], room.begin[level + 1]
    for action in range(actions):
        for i in range(first, first + count):
            outcome_probabilities(arrays, room.states[i], action, room.probabilities[i])
        total = 0.0
        for observation in range(numbers.outcomes if TELLING else N_OBSERVATIONS):
            reached = 0
            for i in range(first, first + count):
                for outcome in range(numbers.outcomes):
                    weight = room.weights[i] * room.probabilities[i, outcome]
                    if weight <= 0 or (TELLING and outcome != observation):
                        continue
                    place = below + reached
                    for j in range(room.state.size):
                        room.states[place, j] = room.states[i, j]
                    reward = advance(arrays, room.states[place], action, outcome)
                    if not TELLING:
                        weight *= observation_probability(arrays, room.states[place], action, outcome, observation)
                    if weight > 0:
                        total += weight * reward
                        room.weights[place] = weight
                        reached += 1
            if reached > 0 and level + 1 < depth:
                total += numbers.discount * best_return(arrays, room, level + 1, reached, numbers, rng)
            else:
                for place in range(below, below + reached):
                    room.state[:] = room.states[place]
                    value = leaf_value(arrays, room.state, room.moved, room.scratch, numbers, actions, rng)
                    total += numbers.discount * room.weights[place] * value
        room.values[level, action] = total
    return float(room.values[level].max())

"""The compiled tree search behind POMCP and POMCP-Max.

The tree is a struct of arrays. A decision node is a history h of (action, observation) pairs; node 0
is the belief searched from. Per node h and action a (a chance node):
    child[h, a, o]  the node of history (h, a, o), or -1
    tried[h, a]     how often a was chosen in h
    value[h, a]     estimated return of choosing a in h
    mean_reward[h, a]  mean immediate reward of a in h
    visited[h]      how often h was reached, its creation included; actions were tried visited - 1 times
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.compiled import compiled
from fatigue_planner.pomdp.model import FatiguePomdp
from fatigue_planner.pomdp.preference_choice import normalise_choice

Vector = NDArray[np.float64]
Array = NDArray[np.float64]
Counts = NDArray[np.int64]

UNVISITED = -1
# Entries are summed in this many independent sums, which the compiler turns into vector instructions;
# one running sum would wait for itself at every entry.
LANES = 4


class SearchModel(NamedTuple):
    """The part of a FatiguePomdp that the search reads.

    gain, offset (A * U, L): row a * U + u is the map of action a and preference u; `sharp` says that
    the observation always is the preference.
    """

    gain: Array
    offset: Array
    observation: Array
    sharp: bool
    expertise: float
    discount: float
    cost_scale: float


def search_model(model: FatiguePomdp) -> SearchModel:
    """The search's view of a POMDP."""
    return SearchModel(
        padded(model.gain.reshape(-1, model.live.size)),
        padded(model.offset.reshape(-1, model.live.size)),
        model.observation,
        bool((model.observation == np.eye(*model.observation.shape)).all()),
        float(model.expertise),
        float(model.discount),
        1 / model.entries,
    )


def padded(rows: Array) -> Array:
    """Rows (n, L) with their live entries padded with zeros to a multiple of LANES."""
    return np.pad(rows, [(0, 0), (0, -rows.shape[1] % LANES)])


class Tree(NamedTuple):
    """The arrays described above, sized for a number of nodes."""

    child: Counts
    tried: Counts
    value: Array
    mean_reward: Array
    visited: Counts


@compiled
def draw(probabilities: Vector, rng: np.random.Generator) -> int:
    """An index with these probabilities (n,), from one uniform draw."""
    threshold = rng.random()
    for index in range(probabilities.size - 1):
        threshold -= probabilities[index]
        if threshold < 0:
            return index
    return int(probabilities.size - 1)


@compiled
def sum_of_squares_after(gain: Array, offset: Array, row: int, state: Vector) -> float:
    """Sum of the squares of gain * state + offset; rows of (n, L), L a multiple of LANES."""
    s0 = s1 = s2 = s3 = 0.0
    for j in range(0, state.size, LANES):
        f0 = gain[row, j] * state[j] + offset[row, j]
        f1 = gain[row, j + 1] * state[j + 1] + offset[row, j + 1]
        f2 = gain[row, j + 2] * state[j + 2] + offset[row, j + 2]
        f3 = gain[row, j + 3] * state[j + 3] + offset[row, j + 3]
        s0 += f0 * f0
        s1 += f1 * f1
        s2 += f2 * f2
        s3 += f3 * f3
    return (s0 + s1) + (s2 + s3)


@compiled
def advance(gain: Array, offset: Array, row: int, state: Vector) -> float:
    """state := gain * state + offset in place; the sum of the squares of the new state."""
    s0 = s1 = s2 = s3 = 0.0
    for j in range(0, state.size, LANES):
        f0 = gain[row, j] * state[j] + offset[row, j]
        f1 = gain[row, j + 1] * state[j + 1] + offset[row, j + 1]
        f2 = gain[row, j + 2] * state[j + 2] + offset[row, j + 2]
        f3 = gain[row, j + 3] * state[j + 3] + offset[row, j + 3]
        state[j], state[j + 1], state[j + 2], state[j + 3] = f0, f1, f2, f3
        s0 += f0 * f0
        s1 += f1 * f1
        s2 += f2 * f2
        s3 += f3 * f3
    return (s0 + s1) + (s2 + s3)


@compiled
def sample_preference(
    gain: Array,
    offset: Array,
    first_row: int,
    state: Vector,
    expertise: float,
    cost_scale: float,
    scratch: Vector,
    rng: np.random.Generator,
) -> int:
    """A preference with the probabilities of Eq. 4; `scratch` (U,) is overwritten.

    Rows first_row ... first_row + U - 1 hold the maps of the action's reactions.
    """
    if expertise == 0:
        return int(rng.random() * scratch.size)
    for u in range(scratch.size):
        scratch[u] = cost_scale * sum_of_squares_after(gain, offset, first_row + u, state)
    normalise_choice(scratch, expertise)
    return draw(scratch, rng)


@compiled
def select_action(tried: Counts, value: Array, node: int, times: int, exploration_constant: float) -> int:
    """UCB1: the first action not tried yet, else argmax value + c sqrt(log N(h) / N(h, a)).

    Equal scores go to the first action, so a problem without chance has one search tree.
    """
    log_times = np.log(times)
    best, best_score = 0, -np.inf
    for action in range(tried.shape[1]):
        if tried[node, action] == 0:
            return action
        score = value[node, action] + exploration_constant * np.sqrt(log_times / tried[node, action])
        if score > best_score:
            best, best_score = action, score
    return best


@compiled
def best_value(tried: Counts, value: Array, node: int) -> float:
    """MaxUCT's value of a decision node: the best action tried; 0 for a leaf, where a descent ends."""
    best = -np.inf
    for action in range(tried.shape[1]):
        if tried[node, action] > 0 and value[node, action] > best:
            best = value[node, action]
    return 0.0 if best == -np.inf else best


@compiled
def search(
    model: SearchModel,
    states: Array,
    weights: Vector,
    descents: int,
    exploration_constant: float,
    maximise: bool,
    rng: np.random.Generator,
) -> Tree:
    """Grow a tree from a belief (states (n, L), weights (n,)) by a number of descents.

    A descent samples a state, follows UCB1 and the generative model (paper, Fig. 4) through the tree,
    and stops at the leaf it adds (paper, section III-D). Going back up, POMCP folds the descent's
    discounted return into the mean of every chance node it passed. POMCP-Max (`maximise`; MaxUCT,
    Keller & Helmert 2013) sets
        Q(h, a) = mean reward + gamma * mean over the visits of the successors' current V,
        V(h) = max over the actions tried of Q(h, a).
    """
    gain, offset, observe, sharp = model.gain, model.offset, model.observation, model.sharp
    expertise, discount, cost_scale = model.expertise, model.discount, model.cost_scale
    preferences, observations = observe.shape
    actions = gain.shape[0] // preferences
    size = descents + 1
    child = np.full((size, actions, observations), UNVISITED)
    tried, visited = np.zeros((size, actions), np.int64), np.zeros(size, np.int64)
    value, mean_reward = np.zeros((size, actions)), np.zeros((size, actions))
    visited[0] = used = 1
    state, scratch = np.empty(gain.shape[1]), np.empty(preferences)
    nodes, taken, rewards = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size)
    for _ in range(descents):
        particle = draw(weights, rng) if weights.size > 1 else 0
        for j in range(state.size):
            state[j] = states[particle, j]
        node = 0
        depth = 0
        while node != UNVISITED:
            action = select_action(tried, value, node, visited[node] - 1, exploration_constant)
            visited[node] += 1
            first = action * preferences
            preference = sample_preference(gain, offset, first, state, expertise, cost_scale, scratch, rng)
            rewards[depth] = -cost_scale * advance(gain, offset, first + preference, state)
            observation = preference if sharp else draw(observe[preference], rng)
            nodes[depth], taken[depth] = node, action
            depth += 1
            successor = child[node, action, observation]
            if successor == UNVISITED:
                child[node, action, observation] = used
                visited[used] = 1
                used += 1
            node = successor
        total = 0.0
        for level in range(depth - 1, -1, -1):
            node, action = nodes[level], taken[level]
            tried[node, action] += 1
            if maximise:
                mean_reward[node, action] += (rewards[level] - mean_reward[node, action]) / tried[node, action]
                future = 0.0
                for observation in range(observations):
                    successor = child[node, action, observation]
                    if successor != UNVISITED:
                        future += visited[successor] * best_value(tried, value, successor)
                value[node, action] = mean_reward[node, action] + discount * future / tried[node, action]
            else:
                total = rewards[level] + discount * total
                value[node, action] += (total - value[node, action]) / tried[node, action]
    return Tree(child, tried, value, mean_reward, visited)

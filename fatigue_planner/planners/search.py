"""The compiled tree search behind POMCP and POMCP-Max.

The tree is a struct of arrays. A decision node is a history h of (action, observation) pairs; node 0
is the belief searched from. Per node h and action a (a chance node):
    child[h, a, o]  the node of history (h, a, o), or -1
    tried[h, a]     how often a was chosen in h
    value[h, a]     estimated return of choosing a in h
    reward[h, a]    mean immediate reward of a in h
    visited[h]      how often h was reached
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.compiled import compiled
from fatigue_planner.pomdp.preference_choice import preference_probabilities

Vector = NDArray[np.float64]
Array = NDArray[np.float64]
Counts = NDArray[np.int64]

UNVISITED = -1


class SearchModel(NamedTuple):
    """The part of a FatiguePomdp that the search reads."""

    gain: Array
    offset: Array
    observation: Array
    expertise: float
    discount: float
    cost_scale: float


class Tree(NamedTuple):
    """The arrays described above, sized for a number of nodes."""

    child: Counts
    tried: Counts
    value: Array
    reward: Array
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
def transition(
    model: SearchModel, state: Vector, action: int, scratch: Vector, rng: np.random.Generator
) -> tuple[int, float]:
    """Generative model (paper, Fig. 4): move `state` (L,) in place; observation and reward.

    `scratch` (U,) is overwritten.
    """
    gain, offset = model.gain[action], model.offset[action]
    preferences, live = gain.shape
    if model.expertise == 0:
        preference = int(rng.random() * preferences)
    else:
        for u in range(preferences):
            total = 0.0
            for j in range(live):
                fatigue = gain[u, j] * state[j] + offset[u, j]
                total += fatigue * fatigue
            scratch[u] = total * model.cost_scale
        preference = draw(preference_probabilities(scratch, model.expertise), rng)
    total = 0.0
    for j in range(live):
        fatigue = gain[preference, j] * state[j] + offset[preference, j]
        state[j] = fatigue
        total += fatigue * fatigue
    if model.observation[preference, preference] == 1:
        observation = preference
    else:
        observation = draw(model.observation[preference], rng)
    return observation, -total * model.cost_scale


@compiled
def select_action(tree: Tree, node: int, exploration_constant: float) -> int:
    """UCB1: the first action not tried yet, else argmax value + c sqrt(log N(h) / N(h, a)).

    Equal scores go to the first action, so a problem without chance has one search tree.
    """
    actions = tree.tried.shape[1]
    times = 0
    for action in range(actions):
        if tree.tried[node, action] == 0:
            return action
        times += tree.tried[node, action]
    log_times = np.log(times)
    best, best_score = 0, -np.inf
    for action in range(actions):
        score = tree.value[node, action] + exploration_constant * np.sqrt(log_times / tree.tried[node, action])
        if score > best_score:
            best, best_score = action, score
    return best


@compiled
def node_value(tree: Tree, node: int) -> float:
    """MaxUCT's value of a decision node: the best action tried; 0 for a leaf, where a descent ends."""
    best = -np.inf
    for action in range(tree.tried.shape[1]):
        if tree.tried[node, action] > 0 and tree.value[node, action] > best:
            best = tree.value[node, action]
    return 0.0 if best == -np.inf else best


@compiled
def back_up_mean(tree: Tree, nodes: Counts, actions: Counts, rewards: Vector, depth: int, discount: float) -> None:
    """POMCP: fold the discounted return of the descent into the mean of every chance node it passed."""
    total = 0.0
    for level in range(depth - 1, -1, -1):
        node, action = nodes[level], actions[level]
        total = rewards[level] + discount * total
        tree.tried[node, action] += 1
        tree.value[node, action] += (total - tree.value[node, action]) / tree.tried[node, action]


@compiled
def back_up_max(tree: Tree, nodes: Counts, actions: Counts, rewards: Vector, depth: int, discount: float) -> None:
    """POMCP-Max (MaxUCT, Keller & Helmert 2013), from the leaf to the root.

    Q(h, a) = mean reward + gamma * average of the successors' current values, weighted by visits;
    V(h) = max over the actions tried of Q(h, a).
    """
    for level in range(depth - 1, -1, -1):
        node, action = nodes[level], actions[level]
        tree.tried[node, action] += 1
        tree.reward[node, action] += (rewards[level] - tree.reward[node, action]) / tree.tried[node, action]
        future = 0.0
        for observation in range(tree.child.shape[2]):
            successor = tree.child[node, action, observation]
            if successor != UNVISITED:
                future += tree.visited[successor] * node_value(tree, successor)
        tree.value[node, action] = tree.reward[node, action] + discount * future / tree.tried[node, action]


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

    A descent samples a state, follows UCB1 and the generative model through the tree, and stops at
    the leaf it adds (paper, section III-D); its rewards are backed up by their mean (POMCP) or, with
    `maximise`, as MaxUCT (POMCP-Max).
    """
    actions, preferences, live = model.gain.shape
    observations = model.observation.shape[1]
    size = descents + 1
    tree = Tree(
        np.full((size, actions, observations), UNVISITED),
        np.zeros((size, actions), np.int64),
        np.zeros((size, actions)),
        np.zeros((size, actions)),
        np.zeros(size, np.int64),
    )
    used = 1
    state, scratch = np.empty(live), np.empty(preferences)
    nodes, taken, rewards = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size)
    for _ in range(descents):
        state[:] = states[draw(weights, rng)] if weights.size > 1 else states[0]
        node = 0
        depth = 0
        tree.visited[0] += 1
        while node != UNVISITED:
            action = select_action(tree, node, exploration_constant)
            observation, reward = transition(model, state, action, scratch, rng)
            nodes[depth], taken[depth], rewards[depth] = node, action, reward
            depth += 1
            successor = tree.child[node, action, observation]
            if successor == UNVISITED:
                tree.child[node, action, observation] = used
                tree.visited[used] = 1
                used += 1
            else:
                tree.visited[successor] += 1
            node = successor
        if maximise:
            back_up_max(tree, nodes, taken, rewards, depth, model.discount)
        else:
            back_up_mean(tree, nodes, taken, rewards, depth, model.discount)
    return tree

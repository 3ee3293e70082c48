"""Weighted beliefs in the nodes of a tree (POMCPOW, Sunberg & Kochenderfer 2018, algorithm 2).

A node's particles are the states that descents reached it with, each weighted by how likely it makes the node's
observation, with the reward on the way there. They lie in chunks of 1, 1, 2, 4, 8, ... places of one pool, which holds
the running sum of a node's weights: so nothing is ever copied, and a draw is a binary search.
"""

import numpy as np

from fatigue_planner.core.jit import inlined
from fatigue_planner.planners.pomcp.sparse.tree import Index, SparseTree, Vector


@inlined
def add_particle(tree: SparseTree, index: Index, state: Vector, reward: float, weight: float) -> None:
    """Add a weighted state to the belief of a node. A weight that is no number counts as 0."""
    node = tree.nodes[index]
    count, total = node.particles, 0.0
    if count > 0:
        total = tree.sums[node.chunk + count - 1 - node.older]
    if count == 0 or count - node.older == max(1, node.older):
        tree.before[tree.used[1]] = node.chunk
        node.chunk, node.older = tree.used[1], count
        tree.used[1] += max(1, count)
    place = node.chunk + count - node.older
    for j in range(state.size):
        tree.particles[place, j] = state[j]
    tree.rewards[place] = reward
    tree.sums[place] = total + (weight if weight > 0 and weight < np.inf else 0.0)
    node.particles = count + 1


@inlined
def draw_particle(tree: SparseTree, index: Index, uniform: float) -> Index:
    """The place of a particle of a node, drawn by weight; the newest if no weight is positive."""
    node = tree.nodes[index]
    first, base, count = node.chunk, node.older, node.particles - node.older
    wanted = uniform * tree.sums[first + count - 1]
    while base > 0:
        earlier = tree.before[first]
        if wanted >= tree.sums[earlier + (base - base // 2) - 1]:
            break
        first, base, count = earlier, base // 2, base - base // 2
    low, high = first, first + count - 1
    while low < high:
        middle = (low + high) // 2
        if tree.sums[middle] > wanted:
            high = middle
        else:
            low = middle + 1
    return low

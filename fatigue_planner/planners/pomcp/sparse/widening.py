"""Double progressive widening: how many actions and observations a node has grows with how often it is visited.

After N visits a node considers the first k N^alpha of its legal actions, in the problem's order; below an action tried
N times there are at most k N^alpha observations and one (Couëtoux et al. 2011; POMCPOW, Sunberg & Kochenderfer 2018).
"""

from typing import Any, NamedTuple

import numpy as np

from fatigue_planner.core.jit import inlined
from fatigue_planner.planners.pomcp.search import Node
from fatigue_planner.planners.pomcp.sparse.beliefs import add_particle, draw_particle
from fatigue_planner.planners.pomcp.sparse.tree import NONE, Index, SparseTree, add_node, slot_of
from fatigue_planner.planners.pomcp.tree import Vector
from fatigue_planner.pomdp.parts import (
    advance,
    draw,
    draw_observation,
    is_terminal,
    observation_probability,
    outcome_probabilities,
    step,
)

# Where a descent leads to from a node: nowhere, as the task has ended.
END = -1


class Widening(NamedTuple):
    """The constants of both rules; `observation` (W,) is scratch."""

    actions_k: float
    actions_alpha: float
    observations_k: float
    observations_alpha: float
    observation: Vector


@inlined
def all_actions(_node: Node, _wide: Widening) -> float:
    """Without widening every action is considered."""
    return np.inf


@inlined
def widened_actions(node: Node, wide: Widening) -> float:
    """At least one."""
    return float(max(1.0, wide.actions_k * float(node.visited) ** wide.actions_alpha))


def follow(
    arrays: Any, tree: SparseTree, index: Index, action: int, workspace: Any, _wide: Widening, rng: np.random.Generator
) -> tuple[Index, float, bool]:
    """Template: one step as in POMCP, with a child for every observation: the node reached or END, reward, if new."""
    state = workspace.state
    observation, reward = step(arrays, state, action, workspace.probabilities, rng)
    if is_terminal(arrays, state):
        return END, reward, False
    slot = slot_of(tree, index, action, observation)
    child: Index = np.int64(tree.table[slot])
    if child != NONE:
        return child, reward, False
    child = add_node(tree, index, action, observation)
    tree.table[slot] = child
    return child, reward, True


CONTINUOUS = False
N_OBSERVATIONS = 0


def see(arrays: Any, state: Vector, action: int, outcome: int, observation: Vector, rng: np.random.Generator) -> None:
    """Template: draw an observation into `observation` (W,); of finitely many, its index."""
    if CONTINUOUS:
        draw_observation(arrays, state, action, outcome, observation, rng)
    else:
        uniform = rng.random()
        last = 0
        for index in range(N_OBSERVATIONS):
            probability = observation_probability(arrays, state, action, outcome, index)
            if probability > 0:
                last = index
                uniform -= probability
                if uniform < 0:
                    break
        observation[0] = last


def likelihood(arrays: Any, state: Vector, action: int, outcome: int, observation: Vector) -> float:
    """Template: the probability, or density, of an observation as `see` draws it."""
    if CONTINUOUS:
        return float(observation_probability(arrays, state, action, outcome, observation))
    return float(observation_probability(arrays, state, action, outcome, int(observation[0])))


@inlined
def same(tree: SparseTree, index: Index, observation: Vector) -> bool:
    """Whether a node's observation is this one."""
    different = 0
    for j in range(observation.size):
        different += tree.seen[index, j] != observation[j]
    return different == 0


@inlined
def child_seen(tree: SparseTree, index: Index, action: int, observation: Vector) -> Index:
    """The child of a node with an observation, or NONE."""
    child: Index = np.int64(tree.nodes[index].first[action])
    while child != NONE and not same(tree, child, observation):
        child = np.int64(tree.nodes[child].sibling)
    return child


@inlined
def child_by_draws(tree: SparseTree, index: Index, action: int, uniform: float) -> Index:
    """A child, as likely as its observation was drawn."""
    wanted = int(uniform * tree.nodes[index].drawn_below[action])
    child: Index = np.int64(tree.nodes[index].first[action])
    while wanted >= tree.nodes[child].drawn:
        wanted -= tree.nodes[child].drawn
        child = np.int64(tree.nodes[child].sibling)
    return child


def follow_widened(
    arrays: Any, tree: SparseTree, index: Index, action: int, workspace: Any, wide: Widening, rng: np.random.Generator
) -> tuple[Index, float, bool]:
    """Template: one step as in POMCPOW: the node reached or END, the reward on the way to it, and whether it is new.

    While there is room for more observations, one is drawn; else one of those there are. The state joins the belief of
    that node, with the likelihood of its observation as weight, and the descent goes on from a state of that belief.
    Of finitely many observations, one that was drawn from the state itself has been weighed by that already: it counts
    1, another its likelihood over the chance that it was chosen. (POMCPOW weighs the former twice, which does not
    matter where hardly any observation is drawn twice.)
    """
    state, observation, node = workspace.state, wide.observation, tree.nodes[index]
    outcome_probabilities(arrays, state, action, workspace.probabilities)
    outcome = draw(workspace.probabilities, rng.random())
    reward = advance(arrays, state, action, outcome)
    if is_terminal(arrays, state):
        return END, reward, False
    is_new = False
    if node.children[action] <= wide.observations_k * float(node.tried[action]) ** wide.observations_alpha:
        see(arrays, state, action, outcome, observation, rng)
        child = child_seen(tree, index, action, observation)
        if child == NONE:
            is_new = True
            child = add_node(tree, index, action, 0)
            for j in range(observation.size):
                tree.seen[child, j] = observation[j]
        tree.nodes[child].drawn += np.uint32(1)
        node.drawn_below[action] += np.uint32(1)
        weight = likelihood(arrays, state, action, outcome, observation) if CONTINUOUS else 1.0
    else:
        child = child_by_draws(tree, index, action, rng.random())
        weight = likelihood(arrays, state, action, outcome, tree.seen[child])
        if not CONTINUOUS:
            weight *= node.drawn_below[action] / tree.nodes[child].drawn
    add_particle(tree, child, state, reward, weight)
    if not is_new:
        place = draw_particle(tree, child, rng.random())
        for j in range(state.size):
            state[j] = tree.particles[place, j]
        reward = float(tree.rewards[place])
    return child, reward, is_new

"""How values go up the tree: the mean backup (POMCP), the max backup (POMCP-Max) and the exact one."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined, inlined_for_any_problem
from fatigue_planner.planners.pomcp.buffers import SearchParameters, Workspace
from fatigue_planner.planners.pomcp.search import Node
from fatigue_planner.planners.pomcp.tree import UNVISITED
from fatigue_planner.pomdp.problem import advance, expected_reward, observation_probability


@inlined_for_any_problem
def expect_nothing(_arrays: Any, _node: Node, _action: int, _workspace: Workspace, _certain: bool) -> None:
    """A backup by sampled rewards needs nothing beforehand."""


@inlined
def back_up_mean(_nodes: NDArray[Any], node: Node, action: int, target: float, parameters: SearchParameters) -> float:
    """POMCP: Q(h, a) = mean of the discounted returns of the descents through it, which are passed on as they are."""
    node.value[action] += (target - node.value[action]) * parameters.inverse[node.tried[action]]
    return target


@inlined
def best_value(node: Node) -> float:
    """V(h): the best of the actions tried; an action not yet tried does not count as 0."""
    best = -np.inf
    for action in range(node.value.size):
        if node.tried[action] > 0:
            best = max(best, node.value[action])
    return best


@inlined
def back_up_max(_nodes: NDArray[Any], node: Node, action: int, target: float, parameters: SearchParameters) -> float:
    """POMCP-Max: Q(h, a) = mean reward + gamma * mean over the visits of the successors' current V.

    MaxUCT (Keller & Helmert 2013) on histories (paper, section III-D).
    V(h) = max over the actions tried of Q(h, a); of a leaf, its leaf value. N visits of value V count N V in
    the sum over the visits, so what a node passes on is by how much that has changed: with the target
    r + gamma (N V - N' V'), the mean over the targets is Q without a look at the other successors.
    """
    node.value[action] += (target - node.value[action]) * parameters.inverse[node.tried[action]]
    before, after = node.best, best_value(node)
    node.best = after
    return float(node.visited * after - (node.visited - 1) * before)


# Whether the observation always reveals the outcome.
OBSERVATION_REVEALS_OUTCOME = False


def expect_outcomes(arrays: Any, node: Node, action: int, workspace: Workspace, certain: bool) -> None:
    """Template: fold the state's expected reward and observation probabilities into their means at (h, a).

    Where the belief is one state and the observation reveals the outcome, the node's state is always the
    same, and so are these; elsewhere they are means over the states sampled.
    """
    if certain and OBSERVATION_REVEALS_OUTCOME and node.tried[action] > 0:
        return
    step_size = 1.0 / (node.tried[action] + 1.0)
    for observation in range(node.chance.shape[1]):
        node.chance[action, observation] *= 1.0 - step_size
    probabilities, moved = workspace.probabilities, workspace.moved
    reward = expected_reward(arrays, workspace.state, action, probabilities, moved)
    node.mean_reward[action] += step_size * (reward - node.mean_reward[action])
    for outcome in range(probabilities.size):
        if OBSERVATION_REVEALS_OUTCOME:
            node.chance[action, outcome] += step_size * probabilities[outcome]
        elif probabilities[outcome] > 0:
            for j in range(moved.size):
                moved[j] = workspace.state[j]
            advance(arrays, moved, action, outcome)
            for observation in range(node.chance.shape[1]):
                seen = observation_probability(arrays, moved, action, outcome, observation)
                node.chance[action, observation] += step_size * probabilities[outcome] * seen


@inlined
def back_up_exact(nodes: NDArray[Any], node: Node, action: int, _target: float, parameters: SearchParameters) -> float:
    """Q(h, a) = expected reward + gamma * expected V of the known successors, weighted by their probabilities.

    The max backup with the known probabilities of the observations in place of their frequencies.
    V(h) = max over the actions tried of Q(h, a); of a leaf, its leaf value. Nothing needs to be passed on.
    """
    future, known = 0.0, 0.0
    for observation in range(node.child.shape[1]):
        successor = node.child[action, observation]
        if successor != UNVISITED:
            chance = node.chance[action, observation]
            future += chance * nodes[successor].best
            known += chance
    node.value[action] = node.mean_reward[action] + parameters.discount * future / known
    node.best = best_value(node)
    return 0.0

"""The exact backup: the max backup with the known chances of the outcomes in place of their frequencies."""

from typing import Any

from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined
from fatigue_planner.planners.pomcp.backups.max import best_value
from fatigue_planner.planners.pomcp.buffers import Numbers, Room
from fatigue_planner.planners.pomcp.search import Node
from fatigue_planner.planners.pomcp.tree import UNVISITED
from fatigue_planner.pomdp.problem import advance, expected_reward, observation_probability

# Whether the observation always tells the outcome.
TELLING = False


def expect_outcomes(arrays: Any, node: Node, action: int, room: Room, certain: bool) -> None:
    """Template: fold expected reward and chances of the observations, from the state, into their means at (h, a).

    Where the belief is one state and the observation tells the outcome, the node's state is always the
    same, and so are these; else they are means over the states sampled.
    """
    if certain and TELLING and node.tried[action] > 0:
        return
    share = 1.0 / (node.tried[action] + 1.0)
    for observation in range(node.chance.shape[1]):
        node.chance[action, observation] *= 1.0 - share
    probabilities, moved = room.probabilities, room.moved
    reward = expected_reward(arrays, room.state, action, probabilities, moved)
    node.mean_reward[action] += share * (reward - node.mean_reward[action])
    for outcome in range(probabilities.size):
        if TELLING:
            node.chance[action, outcome] += share * probabilities[outcome]
        elif probabilities[outcome] > 0:
            for j in range(moved.size):
                moved[j] = room.state[j]
            advance(arrays, moved, action, outcome)
            for observation in range(node.chance.shape[1]):
                seen = observation_probability(arrays, moved, action, outcome, observation)
                node.chance[action, observation] += share * probabilities[outcome] * seen


@inlined
def back_up_exact(nodes: NDArray[Any], node: Node, action: int, _target: float, numbers: Numbers) -> float:
    """Q(h, a) = expected reward + gamma * expected V of the successors known, by their chances.

    V(h) = max over the actions tried of Q(h, a); of a leaf, its leaf value. Nothing need be passed on.
    """
    future, known = 0.0, 0.0
    for observation in range(node.child.shape[1]):
        successor = node.child[action, observation]
        if successor != UNVISITED:
            chance = node.chance[action, observation]
            future += chance * nodes[successor].best
            known += chance
    node.value[action] = node.mean_reward[action] + numbers.discount * future / known
    node.best = best_value(node)
    return 0.0

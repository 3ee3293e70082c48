"""The exact backup: the max backup with the known chances of the outcomes in place of their frequencies."""

from typing import Any

from fatigue_planner.compiled import compiled
from fatigue_planner.planners.backups.max import best_value
from fatigue_planner.planners.search.tree import UNVISITED, Tree, Vector
from fatigue_planner.pomdp.problem import advance, observation_probability, outcome_probabilities


def expect_outcomes(
    arrays: Any, tree: Tree, node: int, action: int, state: Vector, moved: Vector, scratch: Vector, certain: bool
) -> None:
    """Template: fold expected reward and chances of the observations, from `state`, into their means at (h, a).

    Where the belief is one state and the observation tells the outcome, the node's state is always the
    same, and so are these; else they are means over the states sampled.
    """
    if certain and TELLING and tree.tried[node, action] > 0:
        return
    share = 1.0 / (tree.tried[node, action] + 1)
    reward = 0.0
    chance = tree.chance[node, action]
    for observation in range(chance.size):
        chance[observation] *= 1.0 - share
    outcome_probabilities(arrays, state, action, scratch)
    for outcome in range(scratch.size):
        if scratch[outcome] > 0:
            for j in range(state.size):
                moved[j] = state[j]
            reward += scratch[outcome] * advance(arrays, moved, action, outcome)
            for observation in range(chance.size):
                seen = observation_probability(arrays, moved, action, outcome, observation)
                chance[observation] += share * scratch[outcome] * seen
    tree.mean_reward[node, action] += share * (reward - tree.mean_reward[node, action])


# Whether the observation always tells the state reached.
TELLING = False


@compiled
def back_up_exact(tree: Tree, node: int, action: int, _reward: float, _gained: float, discount: float) -> None:
    """Q(h, a) = expected reward + gamma * expected V of the successors known, by their chances.

    V(h) = max over the actions tried of Q(h, a); of a leaf, its leaf value.
    """
    future, known = 0.0, 0.0
    for observation in range(tree.child.shape[2]):
        successor = tree.child[node, action, observation]
        if successor != UNVISITED:
            chance = tree.chance[node, action, observation]
            future += chance * tree.best[successor]
            known += chance
    tree.value[node, action] = tree.mean_reward[node, action] + discount * future / known
    tree.best[node] = best_value(tree, node)

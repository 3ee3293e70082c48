"""The kernel of the search of any problem: the descents of `pomcp.search` in a sparse tree.

In a problem without any of the optional functions it grows the same tree as the dense search, descent by descent.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.pomcp.buffers import SearchParameters, Workspace
from fatigue_planner.planners.pomcp.search import back_up, leaf_value, note_return
from fatigue_planner.planners.pomcp.sparse.actions import NO_ACTION, begin_with_prior, best_legal_action
from fatigue_planner.planners.pomcp.sparse.tree import Index, SparseTree, has_room
from fatigue_planner.planners.pomcp.sparse.widening import Widening, follow
from fatigue_planner.planners.pomcp.tree import Array, Vector
from fatigue_planner.pomdp.parts import draw


def grow(
    arrays: Any,
    bound_arrays: Any,
    states: Array,
    weights: Vector,
    legal: NDArray[np.bool_],
    every: NDArray[np.bool_],
    tree: SparseTree,
    workspace: Workspace,
    wide: Widening,
    descents: int,
    parameters: SearchParameters,
    rng: np.random.Generator,
) -> tuple[int, int]:
    """Template: grow a tree by some descents, fewer if it has no room for more: how many, and the greatest depth.

    `legal` (A,) are the actions that every state of the belief (states (n, L), weights (n,)) permits: no other is taken
    at the root. `every` (A,) is all true: below it counts what the sampled state permits. A descent ends in a new leaf,
    at the end of the task, or where no action is legal, which is worth nothing.
    """
    nodes, state = tree.nodes, workspace.state
    certain = weights.size == 1
    max_depth, done = 0, 0
    while done < descents and has_room(tree):
        particle = 0 if certain else draw(weights, rng.random())
        for j in range(state.size):
            state[j] = states[particle, j]
        if nodes[0].visited == 1:
            begin_with_prior(arrays, state, nodes[0])
            for action in range(tree.prior.size):
                tree.prior[action] = nodes[0].tried[action]
        index: Index = np.int64(0)
        depth, is_new = 0, False
        while index >= 0 and not is_new:
            node = nodes[index]
            action = best_legal_action(arrays, state, node, legal if index == 0 else every, parameters, wide)
            if action == NO_ACTION:
                break
            node.visited += np.uint32(1)
            workspace.nodes[depth], workspace.actions[depth] = index, action
            index, reward, is_new = follow(arrays, tree, index, action, workspace, wide, rng)
            workspace.rewards[depth] = reward
            depth += 1
        discounted_return = 0.0
        if is_new:
            begin_with_prior(arrays, state, nodes[index])
            discounted_return = leaf_value(arrays, bound_arrays, workspace, parameters, tree.prior.size, rng)
            nodes[index].best = discounted_return
        done += 1
        max_depth = max(max_depth, depth)
        passed_on = discounted_return
        for level in range(depth - 1, -1, -1):
            above = nodes[workspace.nodes[level]]
            taken, gained = workspace.actions[level], workspace.rewards[level]
            above.tried[taken] += np.uint32(1)
            passed_on = back_up(nodes, above, taken, gained + parameters.discount * passed_on, parameters)
            discounted_return = gained + parameters.discount * discounted_return
            note_return(above, discounted_return)
    return done, max_depth

"""The kernel of the tree search: a template for a problem's functions and the parts of a search.

A descent samples a state from the belief, follows the exploration rule and the generative model (paper,
Fig. 4) through the tree to the leaf it adds (paper, section III-D), takes the leaf's value, and the
backup carries the return to the root.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.pcg64 import uniform
from fatigue_planner.planners.pomcp.buffers import SearchParameters, Workspace
from fatigue_planner.planners.pomcp.tree import UNVISITED, Array, Tree, Vector
from fatigue_planner.pomdp.problem import draw
from fatigue_planner.pomdp.simd import put

Node = Any


def select_action(node: Node, parameters: SearchParameters) -> int:
    """Placeholder for the exploration rule."""
    raise NotImplementedError


def recall(arrays: Any, nodes: NDArray[Any], node: Node, action: int, workspace: Workspace, depth: int) -> int:
    """Placeholder for the node behind an action if the step there is known already, else UNVISITED."""
    raise NotImplementedError


def catch_up(arrays: Any, workspace: Workspace, begin: int, end: int) -> None:
    """Placeholder for bringing `workspace.state` from depth `begin` to depth `end`, along recalled steps."""
    raise NotImplementedError


def take_step(
    arrays: Any, state: Vector, action: int, scratch: Vector, rng: np.random.Generator
) -> tuple[int, float, bool]:
    """Placeholder for a step of the generative model, and whether it always is the same one."""
    raise NotImplementedError


def keep(node: Node, reward: float, always: bool) -> None:
    """Placeholder for what a node keeps of the step that leads there."""
    raise NotImplementedError


def expect(arrays: Any, node: Node, action: int, workspace: Workspace, certain: bool) -> None:
    """Placeholder for what the backup has to know before an action is taken in `workspace.state`."""
    raise NotImplementedError


def leaf_value(
    arrays: Any,
    bound_arrays: Any,
    workspace: Workspace,
    parameters: SearchParameters,
    actions: int,
    rng: np.random.Generator,
) -> float:
    """Placeholder for the value of a new leaf, whose state is `workspace.state`."""
    raise NotImplementedError


def back_up(nodes: NDArray[Any], node: Node, action: int, target: float, parameters: SearchParameters) -> float:
    """Placeholder for the backup of a chance node and its decision node.

    `target` is the reward plus gamma times what the successor's backup (or the leaf value) passed on;
    `tried` and `visited` already count the descent. What it returns is passed on to the node above.
    """
    raise NotImplementedError


def note_return(node: Node, discounted_return: float) -> None:
    """Placeholder for what the exploration rule records about the returns from a node."""
    raise NotImplementedError


def grow(
    arrays: Any,
    bound_arrays: Any,
    states: Array,
    weights: Vector,
    tree: Tree,
    workspace: Workspace,
    descents: int,
    parameters: SearchParameters,
    rng: np.random.Generator,
) -> int:
    """Template: grow a tree by a number of descents from a belief (states (n, L), weights (n,)); its depth.

    The tree must have room for as many nodes. Ties go to the first action, so a problem without chance has one
    tree, whatever the generator (unless leaves are valued by random rollouts). What a node's next action is depends on
    the node alone, so it is chosen as soon as a return is backed up, and the next descent need not wait for it.
    """
    nodes, state = tree.nodes, workspace.state
    used = tree.size[0]
    certain = weights.size == 1
    max_depth = 0
    for _ in range(descents):
        particle = 0 if certain else draw(weights, uniform(rng))
        put(state, states, particle)
        index: Any = np.uint32(0)
        depth, taken = 0, 0  # the state is the one at depth `taken`
        while True:
            node = nodes[index]
            action = node.next
            number: Any = np.int64(action)  # of the type that functions of a problem are compiled for elsewhere
            workspace.nodes[depth], workspace.actions[depth] = index, action
            if certain:
                known = recall(arrays, nodes, node, action, workspace, depth)
                if known != UNVISITED:
                    index = known
                    depth += 1
                    continue
                catch_up(arrays, workspace, taken, depth)
            expect(arrays, node, number, workspace, certain)
            observation, reward, always = take_step(arrays, state, number, workspace.probabilities, rng)
            workspace.rewards[depth] = reward
            depth += 1
            taken = depth
            index = node.child[action, observation]
            if index == UNVISITED:
                node.child[action, observation] = used
                keep(nodes[used], reward, always)
                break
            keep(nodes[index], reward, always)
        discounted_return = leaf_value(arrays, bound_arrays, workspace, parameters, node.value.size, rng)
        nodes[used].visited = 1
        nodes[used].best = discounted_return
        used += 1
        max_depth = max(max_depth, depth)
        passed_on = discounted_return
        for level in range(depth - 1, -1, -1):
            node = nodes[workspace.nodes[level]]
            action, reward = workspace.actions[level], workspace.rewards[level]
            node.visited += np.uint32(1)
            node.tried[action] += np.uint32(1)
            passed_on = back_up(nodes, node, action, reward + parameters.discount * passed_on, parameters)
            discounted_return = reward + parameters.discount * discounted_return
            note_return(node, discounted_return)
            node.next = select_action(node, parameters)
    tree.size[0] = used
    return max_depth

"""The search tree: one record per node.

A decision node is a history h of (action, observation) pairs; node 0 is the belief searched from. Per
node h and action a (a chance node) and, where given, observation o:
    value[a]       estimated return of choosing a in h
    best           value of h: of a leaf its leaf value, else what the backup makes of the actions tried
    next           the action that the next descent chooses in h
    visited        how often h was reached, its creation included; visited - 1 = sum of tried
    tried[a]       how often a was chosen in h
    child[a, o]    the node of history (h, a, o), or UNVISITED
and, only where a part of the search needs them:
    mean_reward[a], chance[a, o]   known expected reward of a and probability of o (exact backup)
    reward                         that of the step that leads to h, or NaN (steps that are always the same)
    spread, average                sum of squared deviations and mean of the returns from h (scaled exploration)
"""

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import kernel
from fatigue_planner.pomdp.simd import CACHE_LINE, aligned_zeros

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# The root is never a child, and fresh memory is all zeros.
UNVISITED = 0


class Tree(NamedTuple):
    """nodes (capacity,): records as described above; size (1,): how many are in use."""

    nodes: NDArray[Any]
    size: NDArray[np.int64]


def node_type(
    actions: int, observations: int, with_chances: bool, with_spread: bool, with_reward: bool
) -> np.dtype[Any]:
    """The record of a node. Up to a cache line its size is a power of two, so that none lies across two lines."""
    fields: list[tuple[Any, ...]] = [("value", np.float64, (actions,)), ("best", np.float64)]
    if with_chances:
        fields += [("mean_reward", np.float64, (actions,)), ("chance", np.float64, (actions, observations))]
    if with_spread:
        fields += [("spread", np.float64), ("average", np.float64)]
    if with_reward:
        fields += [("reward", np.float64)]
    # unsigned, so that numba knows that no index made of them is negative
    fields += [("next", np.uint32), ("visited", np.uint32), ("tried", np.uint32, (actions,))]
    fields += [("child", np.uint32, (actions, observations))]
    sizes = [np.dtype([field]).itemsize for field in fields]
    size = -(-sum(sizes) // 8) * 8
    return np.dtype(
        {
            "names": [field[0] for field in fields],
            "formats": [field[1:] if len(field) > 2 else field[1] for field in fields],
            "offsets": [sum(sizes[:i]) for i in range(len(sizes))],
            "itemsize": size if size > CACHE_LINE else 1 << (size - 1).bit_length(),
        }
    )


def new_tree(capacity: int, record: np.dtype[Any]) -> Tree:
    """A tree that has only its root, with room for `capacity` nodes."""
    nodes = aligned_zeros(capacity, record)
    if numba.config.DISABLE_JIT:
        nodes = nodes.view(np.recarray)  # fields as attributes, as in compiled code
    tree = Tree(nodes, np.zeros(1, np.int64))
    clear(tree)
    return tree


def clear(tree: Tree) -> None:
    """Forget everything but the root."""
    tree.nodes[: tree.size[0]].view(np.uint8)[:] = 0
    tree.nodes["visited"][0] = 1
    tree.size[0] = 1


def graft(source: Tree, root: int, target: Tree) -> None:
    """Copy a node and all below it to the root of an empty tree with room for them."""
    origin = np.empty(source.size[0], np.uint32)
    used = _order_below(source.nodes, root, origin)
    target.nodes[:used] = source.nodes[origin[:used]]
    if "reward" in (target.nodes.dtype.names or ()):
        target.nodes["reward"][:used] = np.nan  # the next belief may be in another state
    _renumber(target.nodes, used)
    target.size[0] = used


@kernel
def _order_below(nodes: NDArray[Any], root: int, origin: NDArray[np.uint32]) -> int:
    """Fill `origin` with `root` and all nodes below it, level by level; their number."""
    origin[0] = root
    done, used = 0, 1
    while done < used:
        node = nodes[origin[done]]
        for action in range(node.child.shape[0]):
            for observation in range(node.child.shape[1]):
                if node.child[action, observation] != UNVISITED:
                    origin[used] = node.child[action, observation]
                    used += 1
        done += 1
    return used


@kernel
def _renumber(nodes: NDArray[Any], used: int) -> None:
    """Number the children in the order in which they come."""
    following = 1
    for index in range(used):
        node = nodes[index]
        for action in range(node.child.shape[0]):
            for observation in range(node.child.shape[1]):
                if node.child[action, observation] != UNVISITED:
                    node.child[action, observation] = following
                    following += 1

"""The sparse tree: children are found by their observation, so memory does not grow with the number of observations.

A node has the fields of the dense tree (`pomcp.tree`) except `child`; instead it knows where it belongs:
    parent, action, observation   its history: that of `parent`, then `action` and (if there are finitely many) this
    sibling                       the node made before it for the same parent and action, or NONE
    first[a], children[a]         the node made last for an action, and how many there are
    drawn, drawn_below[a]         how often its observation was drawn when widening, and the sum over its children
    particles, chunk, older       its belief (see `beliefs`): how many particles, the place of the newest chunk, and how
                                  many particles lie before that
"""

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined, kernel

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# The index of a node or of a place in the pool: an int in Python, an int64 in compiled code.
Index = Any

# The root is nobody's child.
NONE = 0


class SparseTree(NamedTuple):
    """nodes (capacity,), and per node its observation: seen (capacity, W); used (2,): nodes and particles in use.

    table (2 capacity + 1,): nodes by their history, open addressing. prior (A,): visits that the root's actions began
    with. particles (P, L), their rewards (P,), running sums of their weights (P,), and the chunk before (P,).
    """

    nodes: Any
    seen: Array
    used: NDArray[np.int64]
    table: NDArray[np.uint32]
    prior: Vector
    particles: Array
    rewards: Vector
    sums: Vector
    before: NDArray[np.int64]


def node_type(actions: int, with_spread: bool) -> np.dtype[Any]:
    """The record of a node."""
    fields: list[tuple[Any, ...]] = [("value", np.float64, (actions,)), ("best", np.float64)]
    if with_spread:
        fields += [("spread", np.float64), ("average", np.float64)]
    fields += [("observation", np.int64), ("particles", np.int64), ("chunk", np.int64), ("older", np.int64)]
    fields += [(name, np.uint32) for name in ("visited", "parent", "action", "sibling", "drawn")]
    fields += [(name, np.uint32, (actions,)) for name in ("tried", "first", "children", "drawn_below")]
    return np.dtype(fields, align=True)


def new_tree(capacity: int, record: np.dtype[Any], numbers_seen: int, pool: int, width: int) -> SparseTree:
    """A tree that has only its root, with room for `capacity` nodes and `pool` particles of `width` numbers.

    A tree without beliefs has a pool of 0."""
    nodes = np.zeros(capacity, record)
    if numba.config.DISABLE_JIT:
        nodes = nodes.view(np.recarray)  # fields as attributes, as in compiled code
    nodes["visited"][0] = 1
    actions = record["value"].shape[0]
    return SparseTree(
        nodes,
        np.zeros((capacity, numbers_seen)),
        np.array([1, 0]),
        np.zeros(2 * capacity + 1, np.uint32),
        np.zeros(actions),
        np.zeros((pool, width)),
        np.zeros(pool),
        np.zeros(pool),
        np.full(pool, -1),
    )


def larger(tree: SparseTree, capacity: int, pool: int) -> SparseTree:
    """The same tree with more room."""
    made = new_tree(capacity, tree.nodes.dtype, tree.seen.shape[1], pool, tree.particles.shape[1])
    used, particles = tree.used.tolist()
    made.nodes[:used], made.seen[:used], made.used[:], made.prior[:] = (
        tree.nodes[:used],
        tree.seen[:used],
        tree.used,
        tree.prior,
    )
    for name in ("particles", "rewards", "sums", "before"):
        getattr(made, name)[:particles] = getattr(tree, name)[:particles]
    _enter_again(made)
    return made


@inlined
def slot_of(tree: SparseTree, parent: Index, action: int, observation: int) -> Index:
    """Where in the table the node of a history is, or belongs if there is none."""
    actions = tree.prior.size
    slot: Index = ((np.int64(parent) * actions + action) * 1_000_003 + observation) % tree.table.size
    while True:
        index = tree.table[slot]
        if index == NONE:
            return slot
        node = tree.nodes[index]
        if node.parent == parent and node.action == action and node.observation == observation:
            return slot
        slot = slot + 1 if slot + 1 < tree.table.size else 0


@kernel
def _enter_again(tree: SparseTree) -> None:
    """Fill an empty table."""
    for index in range(1, tree.used[0]):
        node = tree.nodes[index]
        tree.table[slot_of(tree, node.parent, node.action, node.observation)] = index


@inlined
def has_room(tree: SparseTree) -> bool:
    """Whether a descent surely fits: it adds one node, and to each belief on its way what that holds, or one."""
    enough = tree.sums.size == 0 or 2 * tree.used[1] + tree.used[0] + 1 <= tree.sums.size
    return bool(tree.used[0] < tree.nodes.size and enough)


@inlined
def add_node(tree: SparseTree, parent: Index, action: int, observation: int) -> Index:
    """A new node; its parent knows it as the last of its siblings."""
    index = tree.used[0]
    tree.used[0] += 1
    node, above = tree.nodes[index], tree.nodes[parent]
    node.visited, node.parent, node.action, node.observation = 1, parent, action, observation
    node.sibling = above.first[action]
    above.first[action] = index
    above.children[action] += np.uint32(1)
    return index

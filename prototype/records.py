"""Prototype: one search kernel, generic in the problem (`begin`, `step`) and its parts (`select`, `backup`, `leaf_value`).

A kernel is made by `bind`: the template's code with its parts as globals, so that numba inlines them and caches the
result on disk under a name of its own.

The tree is one block of memory seen as doubles and as 32-bit counts, one record per node:
    doubles: value (A), best (1);  counts: visited (1), tried (A), child (A * O)
A record starts at a multiple of its size, so that with two actions and two observations it is one cache line.
Child 0 means "none": the root is nobody's child, and fresh memory is all zeros. Counts are unsigned, so that numba
knows that no index made from them is negative and leaves out the wrap-around.
"""

from types import FunctionType
from typing import NamedTuple

import lanes
import numba
import numpy as np


OPTIONS = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}


def compiled(function):
    """A kernel. Without numba's run-time it can neither allocate nor count references to arrays."""
    return numba.njit(**OPTIONS)(function)


def part(function):
    """A function that is inlined where it is called."""
    return numba.njit(forceinline=True, **OPTIONS)(function)


def bind(template, name, **parts):
    """The template compiled with these parts, which numba takes as constants."""
    function = FunctionType(template.__code__, {**template.__globals__, **parts}, name, template.__defaults__)
    function.__qualname__ = name
    function.__module__ = template.__module__
    return compiled(function)


class Tables(NamedTuple):
    """By count n: sqrt(log n), 1 / sqrt(n), 1 / n; see `tables`."""

    root_log: np.ndarray
    inverse_root: np.ndarray
    inverse: np.ndarray


def tables(size):
    """1 / sqrt(0) = inf lets the first action not tried win; log 0 and log 1 are made tiny, as 0 * inf is NaN."""
    n = np.arange(size, dtype=float)
    root_log = np.sqrt(np.log(np.maximum(n, 1)))
    root_log[:2] = 1e-150
    with np.errstate(divide="ignore"):
        return Tables(root_log, 1 / np.sqrt(n), 1 / n)


def node_type(actions, observations):
    """A node's record; up to a cache line its size is a power of two, so that a record straddles none."""
    fields = [
        ("value", np.float64, (actions,)),
        ("best", np.float64),
        ("visited", np.uint32),
        ("tried", np.uint32, (actions,)),
        ("child", np.uint32, (actions, observations)),
    ]
    size = -(-np.dtype(fields).itemsize // 8) * 8
    size = size if size > 64 else 1 << (size - 1).bit_length()
    offsets = [0, *np.cumsum([np.dtype([field]).itemsize for field in fields[:-1]]).tolist()]
    return np.dtype({
        "names": [field[0] for field in fields],
        "formats": [np.dtype(field[1:]) if len(field) > 2 else field[1] for field in fields],
        "offsets": offsets, "itemsize": size,
    })


class Tree(NamedTuple):
    nodes: np.ndarray  # of node_type
    size: np.ndarray  # int64 (1,): nodes in use


def new_tree(capacity, actions, observations):
    nodes = aligned(np.zeros(capacity, node_type(actions, observations)))
    if numba.config.DISABLE_JIT:
        nodes = nodes.view(np.recarray)  # fields as attributes, as in compiled code
    tree = Tree(nodes, np.ones(1, np.int64))
    reset(tree)
    return tree


def reset(tree):
    tree.nodes[: tree.size[0]].view(np.uint8)[:] = 0
    tree.nodes["visited"][0] = 1
    tree.size[0] = 1


def aligned(array):
    """A copy that starts at a cache line."""
    raw = np.zeros(array.nbytes + 64, np.uint8)
    skip = -raw.ctypes.data % 64
    copy = raw[skip : skip + array.nbytes].view(array.dtype).reshape(array.shape)
    copy[...] = array
    return copy


class Workspace(NamedTuple):
    """Arrays a search needs besides the tree: state, path (by depth)."""

    state: np.ndarray
    nodes: np.ndarray  # uint32
    actions: np.ndarray  # uint32
    rewards: np.ndarray


def workspace(capacity, entries):
    return Workspace(
        aligned(np.zeros(entries)), np.empty(capacity, np.uint32), np.empty(capacity, np.uint32), np.empty(capacity)
    )


# --- the fatigue problem ---------------------------------------------------------------------------------------------


class Fatigue(NamedTuple):
    gain: np.ndarray  # (A * U * entries,)
    offset: np.ndarray
    observation: np.ndarray
    sharp: bool
    expertise: float
    cost_scale: float
    costs: np.ndarray  # (U,) scratch
    chances: np.ndarray  # (U,) scratch
    states: np.ndarray
    weights: np.ndarray


@part
def draw(probabilities, threshold):
    for index in range(probabilities.size - 1):
        threshold -= probabilities[index]
        if threshold < 0:
            return index
    return probabilities.size - 1


@part
def begin(data, state, rng):
    """state := a draw from the belief."""
    particle = draw(data.weights, rng.random()) if data.weights.size > 1 else 0
    for j in range(state.size):
        state[j] = data.states[particle, j]


@part
def step(data, state, action, rng):
    """One cycle: (observation, reward)."""
    preferences = data.costs.size
    first = action * preferences * state.size
    if data.expertise == 0:
        preference = int(rng.random() * preferences)
        cost = lanes.advance(data.gain, data.offset, state, first + preference * state.size)
    else:
        lowest, preference = np.inf, 0
        for u in range(preferences):
            cost = lanes.squares_after(data.gain, data.offset, state, first + u * state.size)
            data.costs[u] = cost
            if cost < lowest:
                lowest, preference = cost, u
        threshold = rng.random()
        total = 0.0
        for u in range(preferences):
            excess = data.cost_scale * (data.costs[u] - lowest)
            chance = 1.0 if excess == 0 else (0.0 if data.expertise == np.inf else np.exp(-data.expertise * excess))
            data.chances[u] = chance
            total += chance
        if total > 1:  # else the cheapest is the only one
            preference = draw(data.chances, total * threshold)
        lanes.move(data.gain, data.offset, state, first + preference * state.size)
        cost = data.costs[preference]
    observation = preference if data.sharp else draw(data.observation[preference], rng.random())
    return observation, -data.cost_scale * cost


# --- parts -----------------------------------------------------------------------------------------------------------


@part
def ucb1(node, tables, c):
    """The action with the highest value + c sqrt(log N / n), the first of equals."""
    width = c * tables.root_log[node.visited - 1]
    best, best_score = 0, -np.inf
    for action in range(node.value.size):
        score = node.value[action] + width * tables.inverse_root[node.tried[action]]
        if score > best_score:
            best, best_score = action, score
    return best


@part
def backup_mean(node, carried):
    return carried


@part
def backup_max(node, carried):
    after = -np.inf
    for action in range(node.value.size):
        if node.tried[action] > 0:
            after = max(after, node.value[action])
    before = node.best
    node.best = after
    return node.visited * after - (node.visited - 1) * before


@part
def no_leaf_value(data, state, rng):
    return 0.0


def search(data, tree, tables, work, descents, c, discount, rng):
    """Grow the tree by up to `descents` descents; returns the number of steps."""
    nodes = tree.nodes
    used = tree.size[0]
    steps = 0
    for _ in range(min(descents, nodes.size - used)):
        begin(data, work.state, rng)
        here = np.uint32(0)
        depth = 0
        while True:
            node = nodes[here]
            action = select(node, tables, c)
            node.visited += np.uint32(1)
            observation, reward = step(data, work.state, action, rng)
            work.nodes[depth] = here
            work.actions[depth] = action
            work.rewards[depth] = reward
            depth += 1
            here = node.child[action, observation]
            if here == 0:
                node.child[action, observation] = used
                break
        carried = leaf_value(data, work.state, rng)
        nodes[used].visited = 1
        nodes[used].best = carried
        used += 1
        steps += depth
        for level in range(depth - 1, -1, -1):
            node = nodes[work.nodes[level]]
            action = work.actions[level]
            tried = node.tried[action] + np.uint32(1)
            node.tried[action] = tried
            carried = work.rewards[level] + discount * carried
            node.value[action] += (carried - node.value[action]) * tables.inverse[tried]
            carried = backup(node, carried)
    tree.size[0] = used
    return steps


# --- use -------------------------------------------------------------------------------------------------------------


def kernels():
    """Mean and max."""
    parts = {"begin": begin, "step": step, "select": ucb1, "leaf_value": no_leaf_value}
    return (
        bind(search, "search_fatigue_ucb1_mean", backup=backup_mean, **parts),
        bind(search, "search_fatigue_ucb1_max", backup=backup_max, **parts),
    )


_TABLES = {}


def padded(rows, width=lanes.WIDTH):
    wide = np.zeros((rows.shape[0], -(-rows.shape[1] // width) * width))
    wide[:, : rows.shape[1]] = rows
    return aligned(wide)


_DATA = {}
_MEMORY = {}


def run(kernel, model, belief, descents, c, rng):
    actions, preferences, live = model.gain.shape
    if id(model) not in _DATA:  # in the project: once per policy
        gain = padded(model.gain.reshape(-1, live))
        _DATA[id(model)] = Fatigue(
            gain.ravel(), padded(model.offset.reshape(-1, live)).ravel(), model.observation, True,
            float(model.expertise), 1 / model.entries, np.empty(preferences), np.empty(preferences),
            padded(belief.states), belief.weights,
        )
    if descents not in _TABLES:
        _TABLES[descents] = tables(descents + 2)
    data = _DATA[id(model)]._replace(states=padded(belief.states), weights=belief.weights)
    key = descents, actions, data.states.shape[1]
    if key not in _MEMORY:
        _MEMORY[key] = (
            new_tree(descents + 1, actions, model.observation.shape[1]),
            workspace(descents + 1, data.states.shape[1]),
        )
    tree, work = _MEMORY[key]
    reset(tree)
    steps = kernel(data, tree, _TABLES[descents], work, descents, c, model.discount, rng)
    return tree.nodes["value"][0].copy(), tree.nodes["tried"][0].copy(), steps / descents

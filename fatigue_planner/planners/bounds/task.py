"""The planning problem from one known state, as plain arrays."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Task:
    """One known initial state and what every reaction does to it.

    gain, offset (A, U, L); start (L,); cost_weight (L,), posture_cost (A, U): C(f) = sum of cost_weight * f^2 +
    posture_cost after a reaction; expertise: beta of Eq. 4, 0 to infinity, with the costs C.
    """

    gain: Array
    offset: Array
    start: Vector
    cost_weight: Vector
    posture_cost: Array
    expertise: float
    discount: float

    @property
    def branches(self) -> int:
        """Number of reactions, A * U."""
        return int(self.gain.shape[0] * self.gain.shape[1])

    def reactions(self) -> tuple[Array, Array]:
        """Gain and offset (A * U, L) of the reactions; row a * U + u."""
        return self.gain.reshape(self.branches, -1), self.offset.reshape(self.branches, -1)

    def choice(self, costs: Array) -> Array:
        """Eq. 4 over the last axis of costs (..., U): P(u) = exp(-beta c_u) / sum of exp(-beta c_u')."""
        excess = costs - costs.min(axis=-1, keepdims=True)
        relative = np.exp(-np.multiply(self.expertise, excess, where=excess > 0, out=np.zeros_like(excess)))
        return np.asarray(relative / relative.sum(axis=-1, keepdims=True))


def hidden_state(task: Task, entry_weight: Vector, entries: int, states: Array, weights: Vector) -> Task:
    """The task of a policy for a novice that does not know which of the states (n, L) is the true one.

    The same reactions move all of them, so they are one state of n L entries, each with the cost of its
    probability (n,). Entries that start equal stay equal and are merged. `task` is that of a known state, entry_weight
    (L,) and `entries` (2N) its cost: C(f) = sum of entry_weight f^2 / 2N + posture_cost.
    """
    n, length = states.shape
    pairs = np.stack([np.tile(np.arange(length), n), states.ravel()])
    distinct, group = np.unique(pairs, axis=1, return_inverse=True)
    entry = distinct[0].astype(np.intp)
    cost_weight = np.bincount(group.ravel(), weights=np.repeat(weights, length)) * entry_weight[entry] / entries
    gain, offset = task.gain[:, :, entry], task.offset[:, :, entry]
    return replace(task, gain=gain, offset=offset, start=distinct[1], cost_weight=cost_weight)

"""The planning problem from one known state, as plain arrays, and the states that its histories can lead to."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Task:
    """One known initial state and what every reaction does to it.

    gain, offset (A, U, L); start (L,); cost_weight (L,), posture_cost (A, U): C(f) = sum of cost_weight * f^2 +
    posture_cost after a reaction; expertise: beta of Eq. 4, 0 to infinity, with the costs C; factors (1 or 1 + U, U):
    of the Boltzmann factors, see `FatigueArrays`.
    """

    gain: Array
    offset: Array
    start: Vector
    cost_weight: Vector
    posture_cost: Array
    expertise: float
    discount: float
    factors: Array

    @property
    def branches(self) -> int:
        """Number of reactions, A * U."""
        return int(self.gain.shape[0] * self.gain.shape[1])

    def reactions(self) -> tuple[Array, Array]:
        """Gain and offset (A * U, L) of the reactions; row a * U + u."""
        return self.gain.reshape(self.branches, -1), self.offset.reshape(self.branches, -1)

    def choice(self, costs: Array, factors: Array) -> Array:
        """Eq. 4 over the last axis of costs (..., U): P(u) = exp(-beta c_u) / sum of exp(-beta c_u'), with factors."""
        excess = costs - costs.min(axis=-1, keepdims=True)
        relative = np.exp(-np.multiply(self.expertise, excess, where=excess > 0, out=np.zeros_like(excess))) * factors
        return np.asarray(relative / relative.sum(axis=-1, keepdims=True))

    def factors_after(self, classes: NDArray[np.intp]) -> Array:
        """The factors (N, U) after histories of some classes (N,), whose last reaction is the last digit."""
        return self.factors[1 + classes % self.factors.shape[1] if len(self.factors) > 1 else np.zeros_like(classes)]


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


def class_memory(branches: int, classes: int) -> int:
    """The longest memory k >= 1 with branches^k <= classes."""
    return max(1, int(math.log(classes + 0.5, branches))) if branches > 1 else 1


@dataclass(frozen=True)
class ClassStates:
    """The states each of M classes can hold at one time.

    typical, spread (M, L): mean and standard deviation of the entries if all reactions were equally
    probable. low, high (M, L): every state of the class lies between typical + low and typical + high.
    """

    typical: Array
    spread: Array
    low: Array
    high: Array

    def __getitem__(self, classes: slice) -> "ClassStates":
        """The states of some of the classes."""
        return ClassStates(self.typical[classes], self.spread[classes], self.low[classes], self.high[classes])


class HistoryClasses:
    """The classes m = 0 ... R^k - 1 of histories with k or more reactions, where R = A * U.

    Written in base R, m is the last k reactions, the latest in the last digit.
    """

    def __init__(self, task: Task, memory: int, n_cycles: int) -> None:
        gain, offset = task.reactions()
        size = task.branches**memory
        self.memory = memory
        self.successors = np.arange(size * task.branches).reshape(size, task.branches) % size
        self._gain, self._offset = np.ones((1, task.start.size)), np.zeros((1, task.start.size))
        for _ in range(memory):
            self._offset = (gain * self._offset[:, None] + offset).reshape(-1, task.start.size)
            self._gain = (gain * self._gain[:, None]).reshape(-1, task.start.size)
        low = high = mean = task.start
        square = np.square(mean)
        self._ranges = [(low, high, mean, square)]
        for _ in range(n_cycles):
            low, high = (gain * low + offset).min(axis=0), (gain * high + offset).max(axis=0)
            square = (np.square(gain) * square + 2 * gain * offset * mean + np.square(offset)).mean(axis=0)
            mean = (gain * mean + offset).mean(axis=0)
            self._ranges.append((low, high, mean, square))

    def states(self, time: int) -> ClassStates:
        """The states after `time` >= k cycles: the last k reactions applied to the range reachable before.

        As gain >= 0, a range is mapped end to end.
        """
        low, high, mean, square = self._ranges[time - self.memory]
        return ClassStates(
            typical=self._gain * mean + self._offset,
            spread=self._gain * np.sqrt(np.maximum(square - np.square(mean), 0)),
            low=self._gain * (low - mean),
            high=self._gain * (high - mean),
        )

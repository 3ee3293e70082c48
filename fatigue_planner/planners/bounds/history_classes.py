"""Histories sorted by their last k reactions, and the states each class can hold."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.bounds.task import Task

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


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

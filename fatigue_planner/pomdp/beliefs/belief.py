"""The base class of beliefs: weighted states of a problem, updated by what is done and seen."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import specialised
from fatigue_planner.pomdp.problem import ROUNDING, Pomdp, Vector, expected_reward

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Belief(ABC):
    """States (n, L) of `model` and their probabilities (n,).

    surprised: the last observation was impossible under the model, so the belief was widened.

    >>> belief = scenario.initial_belief("prior", scenario.model, np.random.default_rng(0))
    >>> belief.model.actions, belief.weights.tolist()
    (('high', 'low'), [1.0])
    """

    model: Pomdp
    states: Array
    weights: Vector
    surprised: bool = False

    def __post_init__(self) -> None:
        """Raise ProblemError for weights that are not probabilities."""
        if self.weights.shape != (len(self.states),):
            raise ProblemError(f"the belief has {len(self.states)} states and weights of shape {self.weights.shape}.")
        total = float(self.weights.sum())
        if not (self.weights >= 0).all() or not abs(total - 1) <= ROUNDING:
            raise ProblemError(f"the weights of the belief sum to {total:.6g}, not to 1, or some are negative.")

    @abstractmethod
    def update(self, action: int, observation: int, rng: np.random.Generator) -> "Belief":
        """The belief after an action and an observation. Works for every observation that the problem has.

        Raises IndexError for an action or observation that the problem does not have.
        """

    def expected_rewards(self) -> Vector:
        """Expected reward of every action for one cycle, (A,)."""
        values = np.zeros(len(self.model.actions))
        kernel = specialised(add_expected_rewards, expected_reward=self.model.parts["expected_reward"])
        kernel(self.model.arrays, self.states, self.weights, len(self.model.outcomes), values)
        return values


def add_expected_rewards(arrays: object, states: Array, weights: Vector, outcomes: int, values: Vector) -> None:
    """Template: add to `values` (A,) the expected reward of every action."""
    probabilities = np.empty(outcomes)
    moved = np.empty(states.shape[1])
    for action in range(values.size):
        for i in range(weights.size):
            values[action] += weights[i] * expected_reward(arrays, states[i], action, probabilities, moved)

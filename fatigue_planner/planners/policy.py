"""What every policy is: it chooses the robot's action from a belief."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Decision:
    """The chosen action (its index) and the estimated return of every action, NaN where unknown."""

    action: int
    values: Vector


class Policy(ABC):
    """A policy for one run of the task; a new one is made for every run."""

    # Whether the policy's own random draws can change its choices in a problem without chance.
    draws_at_random = False

    def __init__(self, model: FatiguePomdp) -> None:
        self.model = model

    @abstractmethod
    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """The action for this cycle. Called once per cycle, in order."""

    def _undecided(self) -> Vector:
        return np.full(len(self.model.actions), np.nan)

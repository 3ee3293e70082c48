"""Policies that do not look ahead (paper, section IV-E)."""

import numpy as np

from fatigue_planner.planners.policy import Decision, Policy
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp


class RandomPolicy(Policy):
    """Any action, with equal probability, every cycle."""

    draws_at_random = True

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act."""
        return Decision(int(rng.integers(len(self.model.actions))), self._undecided())


class AlternatingPolicy(Policy):
    """The actions in turn, in the order of the experiment file."""

    def __init__(self, model: FatiguePomdp) -> None:
        super().__init__(model)
        self._cycle = 0

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act."""
        action = self._cycle % len(self.model.actions)
        self._cycle += 1
        return Decision(action, self._undecided())


class GreedyPolicy(Policy):
    """The action with the lowest expected fatigue cost after one cycle; the first of equals."""

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act."""
        values = np.array([-belief.expected_cost(self.model, action) for action in range(len(self.model.actions))])
        return Decision(int(values.argmax()), values)

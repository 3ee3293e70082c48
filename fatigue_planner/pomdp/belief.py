"""The belief about the worker's fatigue: an exact weighted set of states.

With finitely many initial states and deterministic fatigue (paper, section III-B) the belief stays a
finite set for ever, so nothing is sampled and no particle is lost.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.pomdp.model import FatiguePomdp

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Belief:
    """States (n, L), fatigue of the live entries, and their probabilities (n,)."""

    states: Array
    weights: Vector

    def update(self, model: FatiguePomdp, action: int, observation: int) -> "Belief":
        """Bayes' rule after an action and an observed reaction.

        b'(f') is proportional to the sum over f, u of P(o | u) P(u | f, a) b(f) with f' the fatigue
        that u leaves of f. An observation the model holds impossible from every state says nothing
        about the state: the states then move by the reactions it suggests, with their old weights.
        """
        choice = np.array([model.choice(state, action) for state in self.states])
        likelihood = choice * model.observation[:, observation]
        if not (self.weights @ likelihood).sum() > 0:
            likelihood = np.broadcast_to(model.observation[:, observation], likelihood.shape)
        weights = self.weights[:, None] * likelihood
        moved = np.array([model.next_fatigue(state, action) for state in self.states])
        kept = weights > 0
        return Belief(np.ascontiguousarray(moved[kept]), weights[kept] / weights[kept].sum())

    def expected_cost(self, model: FatiguePomdp, action: int) -> float:
        """Expected fatigue cost after one cycle with the action."""
        costs = [model.choice(state, action) @ model.cost(model.next_fatigue(state, action)) for state in self.states]
        return float(self.weights @ np.array(costs))

"""POMCP and POMCP-Max (paper, section III-D)."""

import numpy as np

from fatigue_planner.planners.policy import Decision, Policy
from fatigue_planner.planners.search import Tree, padded, search, search_model
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp


class PomcpPolicy(Policy):
    """Monte-Carlo tree search from the belief; `maximise` makes it POMCP-Max."""

    def __init__(self, model: FatiguePomdp, descents: int, exploration_constant: float, maximise: bool) -> None:
        super().__init__(model)
        self.descents = descents
        self.exploration_constant = exploration_constant
        self.maximise = maximise
        self._search_model = search_model(model)

    def tree(self, belief: Belief, rng: np.random.Generator) -> Tree:
        """The search tree grown from a belief."""
        return search(
            self._search_model,
            padded(belief.states),
            belief.weights,
            self.descents,
            self.exploration_constant,
            self.maximise,
            rng,
        )

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """The action with the best estimated return at the root; the first of equals."""
        tree = self.tree(belief, rng)
        values = np.where(tree.tried[0] > 0, tree.value[0], -np.inf)
        return Decision(int(values.argmax()), values)

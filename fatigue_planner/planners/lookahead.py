"""The exact reference: full-width expectimax over the belief to a depth in cycles."""

import time

import numpy as np

from fatigue_planner.compiled import kernel, specialised
from fatigue_planner.planners.parts import LEAF_VALUES, bound_arrays_for
from fatigue_planner.planners.policy import Decision, Policy, Vector, plain_decision
from fatigue_planner.planners.search.expectimax import best_return, new_levels
from fatigue_planner.planners.search.numbers import Numbers, new_room, tables
from fatigue_planner.planners.settings import LookaheadSettings
from fatigue_planner.pomdp.beliefs.belief import Belief


class LookaheadPolicy(Policy):
    """The action with the best exact return over a number of cycles, plus leaf values; the first of equals."""

    def __init__(self, settings: LookaheadSettings) -> None:
        self.settings = settings
        # an expert leaves nothing to chance in a greedy rollout; random ones are drawn whatever the worker
        self.draws_at_random = settings.leaf_value == "random_rollout"

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act."""
        begin = time.perf_counter()
        values = self.values(belief, rng)
        depth = self.settings.depth
        reason = f"best exact return of {depth} cycles"
        return plain_decision(int(values.argmax()), values, depth, time.perf_counter() - begin, reason, belief)

    def values(self, belief: Belief, rng: np.random.Generator) -> Vector:
        """The return of every action, followed by the best ones, (A,)."""
        settings, model = self.settings, belief.model
        parts = {name: part for name, part in model.parts.items() if name != "step"}
        enumerate_all = specialised(
            best_return,
            kernel,
            **parts,
            leaf_value=LEAF_VALUES[settings.leaf_value](model),
            TELLING=model.telling,
            N_OBSERVATIONS=len(model.observations),
            LEAVES=settings.leaf_value != "none",
        )
        count, width = belief.states.shape
        outcomes, actions = len(model.outcomes), len(model.actions)
        levels = new_levels(belief.states, settings.depth, outcomes, actions, model.telling)
        levels.states[:count], levels.weights[:count] = belief.states, belief.weights
        bound_arrays = bound_arrays_for(model, settings.leaf_value)
        numbers = Numbers(0.0, model.discount, settings.rollout_cycles, bound_arrays, *tables(0))
        enumerate_all(model.arrays, levels, new_room(width, outcomes, 0), 0, count, numbers, rng)
        return np.asarray(levels.values[0].copy())

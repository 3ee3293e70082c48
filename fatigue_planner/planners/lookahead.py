"""The exact reference: full-width expectimax over the belief to a depth in cycles."""

import time

import numpy as np

from fatigue_planner.compiled import specialised
from fatigue_planner.planners.parts import LEAF_VALUES, bound_arrays_for
from fatigue_planner.planners.policy import Decision, Policy, Vector, plain_decision
from fatigue_planner.planners.search.descent import Numbers
from fatigue_planner.planners.search.expectimax import best_return, room_for
from fatigue_planner.planners.settings import LookaheadSettings
from fatigue_planner.pomdp.beliefs.belief import Belief

NO_TABLE = np.zeros(0)


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
        kernel = specialised(
            best_return,
            **parts,
            leaf_value=LEAF_VALUES[settings.leaf_value](model),
            TELLING=model.telling,
            N_OBSERVATIONS=len(model.observations),
        )
        outcomes, actions = len(model.outcomes), len(model.actions)
        room = room_for(belief.states, settings.depth, outcomes, actions, model.telling)
        count = len(belief.weights)
        room.states[:count], room.weights[:count] = belief.states, belief.weights
        numbers = Numbers(
            exploration_constant=0.0,
            discount=model.discount,
            rollout_cycles=settings.rollout_cycles,
            outcomes=outcomes,
            log_root=NO_TABLE,
            inverse_root=NO_TABLE,
            bound_arrays=bound_arrays_for(model, settings.leaf_value),
        )
        kernel(model.arrays, room, 0, count, numbers, rng)
        return np.asarray(room.values[0].copy())

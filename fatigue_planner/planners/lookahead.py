"""The exact reference: full-width expectimax over the belief to a depth in cycles."""

import time
from typing import Any, Literal

import numpy as np
from pydantic import Field

from fatigue_planner.core.settings import Settings
from fatigue_planner.planners.expectimax import Levels, new_levels
from fatigue_planner.planners.policy import Decision, Policy, PolicySettings, Vector, plain_decision
from fatigue_planner.planners.pomcp.buffers import SearchParameters, new_workspace, tables
from fatigue_planner.planners.pomcp.kernels import (
    LEAF_VALUE,
    ROLLOUT_CYCLES,
    LeafValueName,
    bound_arrays_for,
    lookahead_kernel,
)
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.problem import Pomdp

ReferenceLeafValue = Literal["none", "greedy_rollout", "bound"]


class ReferenceSettings(Settings):
    """The lookahead that `--regret` measures decisions against; it knows the prior of a hidden worker."""

    kind: Literal["lookahead"] = Field(description="Exact lookahead over everything that can happen.")
    depth: int = Field(ge=1, le=30, description="Depth of the lookahead in cycles.")
    # greedy_rollout only where nothing is left to chance: the largest of noisy values is biased upwards
    leaf_value: ReferenceLeafValue = Field(
        default="none",
        description="What a path is worth beyond its last cycle: nothing (none), a rollout of greedy actions, only "
        "where nothing is left to chance (greedy_rollout), or the proven bound of the cost to come (bound).",
    )
    rollout_cycles: int = Field(default=20, ge=1, le=10_000, description=ROLLOUT_CYCLES)


class LookaheadPolicy(Policy):
    """The action with the best exact return over a number of cycles, plus leaf values; ties go to the first.

    Its memory is kept from decision to decision.
    """

    def __init__(self, settings: "LookaheadSettings | ReferenceSettings") -> None:
        self.settings = settings
        # greedy rollouts with an expert leave nothing to chance; random rollouts are drawn for every worker
        self.draws_at_random = settings.leaf_value == "random_rollout"
        self._model: Pomdp | None = None
        self._kernel: Any = None
        self._levels: Levels | None = None
        self._workspace = new_workspace(0, 0, 0)
        self._tables = tables(0)

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
        if model is not self._model:
            if self._model is None:
                model.check_probabilities(belief.states)
            self._model, self._kernel, self._levels = model, lookahead_kernel(model, settings.leaf_value), None
        count, width = belief.states.shape
        if self._levels is None or self._levels.begin[1] != count:
            outcomes, actions = len(model.outcomes), len(model.actions)
            self._levels = new_levels(
                count, width, settings.depth, outcomes, actions, model.observation_reveals_outcome
            )
            self._workspace = new_workspace(width, outcomes, 0)
        levels = self._levels
        levels.states[:count], levels.weights[:count], levels.size[0] = belief.states, belief.weights, count
        bound_arrays = bound_arrays_for(model, settings.leaf_value)
        parameters = SearchParameters(0.0, model.discount, settings.rollout_cycles, *self._tables)
        self._kernel(model.arrays, bound_arrays, levels, self._workspace, parameters, rng)
        return np.asarray(levels.values[0].copy())


class LookaheadSettings(PolicySettings):
    """Full-width expectimax over the belief to a depth in cycles."""

    kind: Literal["lookahead"] = Field(description="Exact lookahead over everything that can happen.")
    depth: int = Field(ge=1, le=30, description="Depth of the lookahead in cycles.")
    leaf_value: LeafValueName = Field(default="none", description=LEAF_VALUE)
    rollout_cycles: int = Field(default=20, ge=1, le=10_000, description=ROLLOUT_CYCLES)

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return LookaheadPolicy(self)

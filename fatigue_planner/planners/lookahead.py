"""Full-width expectimax over the belief to a depth in cycles: a policy, and what decisions are measured against."""

import time
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import specialised
from fatigue_planner.core.settings import Settings
from fatigue_planner.planners.expectimax import Levels, best_return, new_levels
from fatigue_planner.planners.plan_leaves import last_cycles_of, new_ends, plans_in_reach
from fatigue_planner.planners.policy import Decision, Policy, PolicySettings, Rule, Vector, plain_decision
from fatigue_planner.planners.pomcp.buffers import SearchParameters, Workspace, new_workspace, tables
from fatigue_planner.planners.pomcp.kernels import (
    LEAF_VALUE,
    ROLLOUT_CYCLES,
    LeafValueName,
    bound_arrays_for,
    lookahead_kernel,
    values_whole_beliefs,
)
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.beliefs.moments import MIN_STATES, belief_in_moments
from fatigue_planner.pomdp.cyclic_plans import PlanValues, most_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.problem import Pomdp

ReferenceLeafValue = Literal["none", "greedy_rollout", "bound"]
# The most cycle maps that a decision of the reference may apply, and its greatest depth: some 20 ms.
MAX_REFERENCE_MAPS = 300_000
MAX_REFERENCE_DEPTH = 14
REFERENCE_ROLLOUT_CYCLES = 60


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
        self._memory: tuple[Levels, Any] | None = None
        self._shape: tuple[int, ...] = ()
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
        settings, model, belief = self.settings, belief.model, belief.going_on()
        if model is not self._model:
            if self._model is None:
                model.check_probabilities(belief.states)
            if model.is_continuous:
                raise ProblemError(
                    "lookahead goes through every observation; this problem's are continuous: use pomcpow."
                )
            self._model, self._kernel, self._memory = model, lookahead_kernel(model, settings.leaf_value), None
        else:
            model.check_again(belief.states)
        if settings.leaf_value in DRAWS_NOTHING:
            belief = belief_in_moments(belief)
        model = belief.model
        bound_arrays = bound_arrays_for(model, settings.leaf_value)
        if values_whole_beliefs(model, settings.leaf_value):
            bound_arrays = plans_in_reach(belief, bound_arrays, settings.depth)
        levels, ends = self._room(belief, bound_arrays)
        count = len(belief.weights)
        levels.states[:count], levels.weights[:count], levels.size[0] = belief.states, belief.weights, count
        parameters = SearchParameters(0.0, model.discount, settings.rollout_cycles, *self._tables)
        draws = rng if "rollout" in settings.leaf_value else None  # to hand it over takes a quarter of a small decision
        with model.told:
            self._kernel(model.arrays, bound_arrays, levels, ends, self._workspace, parameters, draws)
        return np.asarray(levels.values[0].copy())

    def _room(self, belief: Belief, bound_arrays: Any) -> tuple[Levels, Any]:
        """Working memory, kept from decision to decision on the same problem."""
        plans = bound_arrays.constant.shape[1] if isinstance(bound_arrays, PlanValues) else 0
        shape = *belief.states.shape, plans
        if self._memory is None or self._shape != shape:
            self._memory, self._shape = self._new_room(belief, bound_arrays), shape
            self._workspace = new_workspace(belief.states.shape[1], len(belief.model.outcomes), 0)
        return self._memory

    def _new_room(self, belief: Belief, bound_arrays: Any) -> tuple[Levels, Any]:
        """The levels, and what the last cycles need."""
        model, (count, width), depth = belief.model, belief.states.shape, self.settings.depth
        actions, outcomes, observations = (len(names) for names in (model.actions, model.outcomes, model.observations))
        last = 1
        ends: Any = 0
        if values_whole_beliefs(model, self.settings.leaf_value):
            assert isinstance(model, FatiguePomdp)
            last = last_cycles_of(model, bound_arrays, depth)
            ends = new_ends(actions, outcomes, observations, bound_arrays.constant.shape[1], width, last)
        levels = new_levels(count, width, depth + 1 - last, outcomes, actions, model.observation_reveals_outcome)
        return levels, ends

    def rule(self) -> Rule | None:
        """See Policy.rule; rollouts draw."""
        leaf_value = self.settings.leaf_value
        if leaf_value not in DRAWS_NOTHING:
            return None
        return Rule(
            lambda model: specialised(choose_best, best_return=lookahead_kernel(model, leaf_value)),
            self._rule_memory,
            most_states=MIN_STATES - 1,
        )

    def _rule_memory(self, belief: Belief) -> "RuleMemory":
        settings, model = self.settings, belief.model
        bound_arrays = bound_arrays_for(model, settings.leaf_value)
        return RuleMemory(
            bound_arrays,
            *self._new_room(belief, bound_arrays),
            new_workspace(belief.states.shape[1], len(model.outcomes), 0),
            SearchParameters(0.0, model.discount, settings.rollout_cycles, *tables(0)),
        )


# Leaf values that need no random numbers.
DRAWS_NOTHING = ("none", "bound")


class RuleMemory(NamedTuple):
    """What `choose_best` works with."""

    bound_arrays: Any
    levels: Levels
    ends: Any
    workspace: Workspace
    parameters: SearchParameters


def choose_best(arrays: Any, memory: RuleMemory, states: Array, weights: Vector, rng: np.random.Generator) -> int:
    """Template: the action that LookaheadPolicy takes."""
    levels = memory.levels
    for i in range(weights.size):
        levels.weights[i] = weights[i]
        for j in range(states.shape[1]):
            levels.states[i, j] = states[i, j]
    levels.size[0] = weights.size
    best_return(arrays, memory.bound_arrays, levels, memory.ends, memory.workspace, memory.parameters, rng)
    return int(np.argmax(levels.values[0]))


class LookaheadSettings(PolicySettings):
    """Full-width expectimax over the belief to a depth in cycles."""

    kind: Literal["lookahead"] = Field(description="Exact lookahead over everything that can happen.")
    depth: int = Field(ge=1, le=30, description="Depth of the lookahead in cycles.")
    leaf_value: LeafValueName = Field(default="none", description=LEAF_VALUE)
    rollout_cycles: int = Field(default=20, ge=1, le=10_000, description=ROLLOUT_CYCLES)

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return LookaheadPolicy(self)


def maps_of(settings: ReferenceSettings, belief: Belief) -> float:
    """About how many cycle maps a decision of the reference applies from such a belief."""
    model = belief.model
    assert isinstance(model, FatiguePomdp)
    actions, outcomes = len(model.actions), len(model.outcomes)
    leaf = {
        "none": 0,
        "bound": most_plans(actions),
        "random_rollout": settings.rollout_cycles,
        "greedy_rollout": settings.rollout_cycles * (actions + 1) * outcomes,
    }[settings.leaf_value]
    branches = (
        actions
        * (1 if model.is_experts else outcomes)
        * (1 if model.observation_reveals_outcome else len(model.observations))
    )
    return float(len(belief.weights)) * float(branches) ** settings.depth * (leaf + outcomes)


def reference_for(belief: Belief) -> ReferenceSettings:
    """The lookahead that is used as the reference in a scenario with this initial belief.

    Its leaf values are those of cyclic plans, where the cost is quadratic, or greedy rollouts, where nothing is left to
    chance (an expert), which are better there. All other rollouts are random, and the largest of noisy values is biased
    upwards.
    """
    model = belief.model
    assert isinstance(model, FatiguePomdp)
    leaf_value: ReferenceLeafValue = "bound" if model.discount < 1 and model.cost.is_quadratic else "none"
    if model.is_experts:
        leaf_value = "greedy_rollout"
    chosen = ReferenceSettings(
        kind="lookahead", depth=1, leaf_value=leaf_value, rollout_cycles=REFERENCE_ROLLOUT_CYCLES
    )
    while chosen.depth < MAX_REFERENCE_DEPTH:
        deeper = chosen.model_copy(update={"depth": chosen.depth + 1})
        if maps_of(deeper, belief) > MAX_REFERENCE_MAPS:
            break
        chosen = deeper
    return chosen


def describe(settings: ReferenceSettings) -> str:
    """A lookahead in words."""
    below = {"none": "nothing", "bound": "cyclic plans"}.get(settings.leaf_value, "")
    below = below or f"{settings.leaf_value.replace('_', ' ')}s of {settings.rollout_cycles} cycles"
    cycles = "1 cycle" if settings.depth == 1 else f"{settings.depth} cycles"
    return f"lookahead over {cycles}, then {below}"

"""The reference that other policies' decisions are measured against: the deepest affordable lookahead."""

from fatigue_planner.planners.settings import LookaheadSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.cyclic_plans import cyclic_plans
from fatigue_planner.pomdp.fatigue_model import FatiguePomdp

# Cycle maps a decision of the reference may apply: some 20 ms.
AFFORDABLE = 300_000
ROLLOUT_CYCLES = 60
DEEPEST = 14


def reference_for(belief: Belief) -> LookaheadSettings:
    """The lookahead that is used as the reference in a situation with this initial belief.

    Below its last level stand the values of cyclic plans where these are exact (a novice's choices do not
    depend on fatigue), else greedy rollouts. An expert's choices are certain, so that every action has one
    outcome.
    """
    model = belief.model
    assert isinstance(model, FatiguePomdp)
    actions, outcomes = len(model.actions), len(model.outcomes)
    if model.arrays.even and model.discount < 1:
        leaf_value, leaf = "bound", len(cyclic_plans(actions))
    else:
        leaf_value, leaf = "greedy_rollout", ROLLOUT_CYCLES * (actions + 1) * outcomes
    certain = bool((model.workers.expertise == float("inf")).all())
    branches = actions * (1 if certain else outcomes) * (1 if model.telling else len(model.observations))
    depth = 1
    while depth < DEEPEST and len(belief.weights) * branches ** (depth + 1) * (leaf + outcomes) <= AFFORDABLE:
        depth += 1
    return LookaheadSettings(
        kind="lookahead", depth=depth, leaf_value=leaf_value, rollout_cycles=ROLLOUT_CYCLES, knows="prior"
    )


def describe(settings: LookaheadSettings) -> str:
    """A lookahead in words."""
    below = {"none": "nothing", "bound": "cyclic plans"}.get(settings.leaf_value, "")
    below = below or f"{settings.leaf_value.replace('_', ' ')}s of {settings.rollout_cycles} cycles"
    return f"lookahead over {settings.depth} cycles, then {below}"

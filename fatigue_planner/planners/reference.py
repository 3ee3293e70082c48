"""The reference that other policies' decisions are measured against: the deepest affordable lookahead."""

from fatigue_planner.planners.effort import maps_of
from fatigue_planner.planners.settings import ReferenceLeafValue, ReferenceSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

# Cycle maps a decision of the reference may apply: some 20 ms.
AFFORDABLE = 300_000
ROLLOUT_CYCLES = 60
DEEPEST = 14


def reference_for(belief: Belief) -> ReferenceSettings:
    """The lookahead that is used as the reference in a situation with this initial belief.

    Below its last level stand the values of cyclic plans; where nothing is left to chance (an expert), greedy
    rollouts, which are better there. Other rollouts are chance, and the best of noisy values is too good.
    """
    model = belief.model
    assert isinstance(model, FatiguePomdp)
    leaf_value: ReferenceLeafValue = "bound" if model.discount < 1 else "none"
    if model.is_experts:
        leaf_value = "greedy_rollout"
    chosen = ReferenceSettings(kind="lookahead", depth=1, leaf_value=leaf_value, rollout_cycles=ROLLOUT_CYCLES)
    while chosen.depth < DEEPEST:
        deeper = chosen.model_copy(update={"depth": chosen.depth + 1})
        if maps_of(deeper, belief) > AFFORDABLE:
            break
        chosen = deeper
    return chosen


def describe(settings: ReferenceSettings) -> str:
    """A lookahead in words."""
    below = {"none": "nothing", "bound": "cyclic plans"}.get(settings.leaf_value, "")
    below = below or f"{settings.leaf_value.replace('_', ' ')}s of {settings.rollout_cycles} cycles"
    cycles = "1 cycle" if settings.depth == 1 else f"{settings.depth} cycles"
    return f"lookahead over {cycles}, then {below}"

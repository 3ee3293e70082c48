"""What a lookahead costs, before it is begun."""

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.planners.settings import LookaheadSettings, ReferenceSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.cyclic_plans import cyclic_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

# A decision that applies more cycle maps than this takes minutes, and a belief of more states has no room.
MOST_MAPS = 3e9
MOST_STATES = 1e7


def maps_of(settings: LookaheadSettings | ReferenceSettings, belief: Belief) -> float:
    """About how many cycle maps a decision applies from such a belief."""
    model = belief.model
    assert isinstance(model, FatiguePomdp)
    actions, outcomes = len(model.actions), len(model.outcomes)
    leaf = {
        "none": 0,
        "bound": len(cyclic_plans(actions)),
        "random_rollout": settings.rollout_cycles,
        "greedy_rollout": settings.rollout_cycles * (actions + 1) * outcomes,
    }[settings.leaf_value]
    branches = actions * (1 if model.is_experts else outcomes) * (1 if model.telling else len(model.observations))
    return float(len(belief.weights)) * float(branches) ** settings.depth * (leaf + outcomes)


def check_effort(name: str, settings: LookaheadSettings | ReferenceSettings, belief: Belief) -> None:
    """Raise ExperimentError, naming the key and what is possible, if a decision could never be waited for."""
    model = belief.model
    states = float(len(belief.weights)) * (1.0 if model.telling else float(len(model.outcomes)) ** settings.depth)
    maps = maps_of(settings, belief)
    if maps <= MOST_MAPS and states <= MOST_STATES:
        return
    depth = settings.depth
    while depth > 1 and maps_of(settings.model_copy(update={"depth": depth}), belief) > MOST_MAPS:
        depth -= 1
    raise ExperimentError(
        f"{name}.depth = {settings.depth}: a decision would apply {maps:.0e} cycle maps to beliefs of {states:.0e} "
        f"states; at most {MOST_MAPS:.0e} and {MOST_STATES:.0e} can be waited for, so try {depth} or less."
    )

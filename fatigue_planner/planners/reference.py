"""The reference that decisions are measured against, the deepest affordable lookahead; what a lookahead costs."""

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.planners.lookahead import LookaheadSettings, ReferenceLeafValue, ReferenceSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.cyclic_plans import cyclic_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

# A decision that applies more cycle maps than this takes minutes, and a belief of more states has no room.
MAX_MAPS = 3e9
MAX_STATES = 1e7


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
    branches = (
        actions
        * (1 if model.is_experts else outcomes)
        * (1 if model.observation_reveals_outcome else len(model.observations))
    )
    return float(len(belief.weights)) * float(branches) ** settings.depth * (leaf + outcomes)


def check_effort(name: str, settings: LookaheadSettings | ReferenceSettings, belief: Belief) -> None:
    """Raise ExperimentError, naming the key and what is possible, if a decision could never be waited for."""
    model = belief.model
    states = float(len(belief.weights)) * (
        1.0 if model.observation_reveals_outcome else float(len(model.outcomes)) ** settings.depth
    )
    maps = maps_of(settings, belief)
    if maps <= MAX_MAPS and states <= MAX_STATES:
        return
    depth = settings.depth
    while depth > 1 and maps_of(settings.model_copy(update={"depth": depth}), belief) > MAX_MAPS:
        depth -= 1
    raise ExperimentError(
        f"{name}.depth = {settings.depth}: a decision would apply {maps:.0e} cycle maps to beliefs of {states:.0e} "
        f"states; at most {MAX_MAPS:.0e} and {MAX_STATES:.0e} can be waited for, so try {depth} or less."
    )


# Cycle maps a decision of the reference may apply: some 20 ms.
AFFORDABLE = 300_000
ROLLOUT_CYCLES = 60
DEEPEST = 14


def reference_for(belief: Belief) -> ReferenceSettings:
    """The lookahead that is used as the reference in a scenario with this initial belief.

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

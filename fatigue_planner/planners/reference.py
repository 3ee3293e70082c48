"""The reference that decisions are measured against: the deepest affordable lookahead, by its cost in cycle maps."""

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.planners.lookahead import LookaheadSettings, ReferenceLeafValue, ReferenceSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.cyclic_plans import cyclic_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

# A decision that applies more cycle maps than this takes minutes; a belief of more states does not fit in memory.
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
    """Raise ExperimentError, naming the key and a possible depth, if a decision would take too much time or memory."""
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
        f"states; at most {MAX_MAPS:.0e} and {MAX_STATES:.0e} are allowed. Try {depth} or less."
    )


# The most cycle maps that a decision of the reference may apply, and its greatest depth: some 20 ms.
MAX_REFERENCE_MAPS = 300_000
ROLLOUT_CYCLES = 60
MAX_REFERENCE_DEPTH = 14


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
    chosen = ReferenceSettings(kind="lookahead", depth=1, leaf_value=leaf_value, rollout_cycles=ROLLOUT_CYCLES)
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

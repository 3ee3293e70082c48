"""The bound of a condition whose worker is known, and what decides it."""

from typing import Any

from fatigue_planner.planners.bounds.cost_bound import CostBound, cost_lower_bound
from fatigue_planner.pomdp.scenario import Situation


def bound_of(situation: Situation, n_cycles: int) -> CostBound:
    """The bound of a situation whose worker is known."""
    model = situation.model
    live = model.live.size
    if live == 0:  # nothing ever tires
        return CostBound(cost=0.0, exact=True, state_revealed=False, exact_cycles=n_cycles, memory=0, seconds=0.0)
    shape = (len(model.actions), len(model.outcomes), -1)
    return cost_lower_bound(
        model.arrays.gain.reshape(shape)[:, :, :live],
        model.arrays.offset.reshape(shape)[:, :, :live],
        float(model.workers.expertise[0]),
        situation.states[:, :live],
        situation.weights,
        model.discount,
        model.entries,
        n_cycles,
    )


def fingerprint(situation: Situation) -> dict[str, Any]:
    """All of a situation that decides its bound, as JSON values: not how beliefs are kept, nor what is recognised."""
    model = situation.model
    return {
        "shape": [len(model.actions), len(model.outcomes), model.live.size, model.entries],
        "gain": model.arrays.gain.tolist(),
        "offset": model.arrays.offset.tolist(),
        "expertise": repr(float(model.workers.expertise[0])),
        "states": situation.states.tolist(),
        "weights": situation.weights.tolist(),
        "discount": model.discount,
    }

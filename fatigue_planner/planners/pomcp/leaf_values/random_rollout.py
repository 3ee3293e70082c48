"""The return of a run in which actions are drawn at random (Silver & Veness 2010)."""

from typing import Any

import numpy as np

from fatigue_planner.planners.pomcp.buffers import Numbers, Room
from fatigue_planner.pomdp.problem import step


def random_rollout(
    arrays: Any, _bound_arrays: Any, room: Room, numbers: Numbers, actions: int, rng: np.random.Generator
) -> float:
    """Template: the discounted return of some cycles with random actions; `room.state` is used up."""
    gained, weight = 0.0, 1.0
    for _ in range(numbers.rollout_cycles):
        action = int(rng.random() * actions)
        _, reward = step(arrays, room.state, action, room.probabilities, rng)
        gained += weight * reward
        weight *= numbers.discount
    return gained

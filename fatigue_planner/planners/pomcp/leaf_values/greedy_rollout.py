"""The return of a run in which the action with the best expected reward is taken, from the leaf's state."""

from typing import Any

import numpy as np

from fatigue_planner.planners.pomcp.buffers import Numbers, Room
from fatigue_planner.pomdp.problem import expected_reward, step


def greedy_rollout(
    arrays: Any, _bound_arrays: Any, room: Room, numbers: Numbers, actions: int, rng: np.random.Generator
) -> float:
    """Template: the discounted return of some greedy cycles; `room.state` is used up.

    The rollout knows the sampled state, which a policy would not.
    """
    state, moved, probabilities = room.state, room.moved, room.probabilities
    gained, weight = 0.0, 1.0
    for _ in range(numbers.rollout_cycles):
        best, best_reward = 0, -np.inf
        for action in range(actions):
            expected = expected_reward(arrays, state, action, probabilities, moved)
            if expected > best_reward:
                best, best_reward = action, expected
        _, reward = step(arrays, state, best, probabilities, rng)
        gained += weight * reward
        weight *= numbers.discount
    return gained

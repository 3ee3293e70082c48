"""What the state at a new leaf is worth: nothing, the return of a rollout, or what the problem says."""

from typing import Any

import numpy as np

from fatigue_planner.core.jit import inlined_for_any_problem
from fatigue_planner.planners.pomcp.buffers import Numbers, Room
from fatigue_planner.planners.pomcp.tree import Vector
from fatigue_planner.pomdp.problem import expected_reward, step


@inlined_for_any_problem
def no_value(
    _arrays: Any, _bound_arrays: Any, _room: Room, _numbers: Numbers, _actions: int, _rng: np.random.Generator
) -> float:
    """0: a descent ends at the leaf (paper, section III-D)."""
    return 0.0


def random_rollout(
    arrays: Any, _bound_arrays: Any, room: Room, numbers: Numbers, actions: int, rng: np.random.Generator
) -> float:
    """Template: the discounted return of some cycles with random actions (Silver & Veness 2010); `room.state` is used up."""
    gained, weight = 0.0, 1.0
    for _ in range(numbers.rollout_cycles):
        action = int(rng.random() * actions)
        _, reward = step(arrays, room.state, action, room.probabilities, rng)
        gained += weight * reward
        weight *= numbers.discount
    return gained


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


def bound(bound_arrays: Any, state: Vector) -> float:
    """Stands for the problem's own bound."""
    raise NotImplementedError


def problem_bound(
    _arrays: Any, bound_arrays: Any, room: Room, _numbers: Numbers, _actions: int, _rng: np.random.Generator
) -> float:
    """Template: the problem's bound of the state's value."""
    return bound(bound_arrays, room.state)

"""What the state at a new leaf is worth: nothing, the return of a rollout, or the problem's own bound."""

from typing import Any

import numpy as np

from fatigue_planner.core.jit import inlined_for_any_problem
from fatigue_planner.core.pcg64 import below
from fatigue_planner.planners.pomcp.buffers import SearchParameters, Workspace
from fatigue_planner.pomdp.parts import bound, expected_reward, step


@inlined_for_any_problem
def no_value(
    _arrays: Any,
    _bound_arrays: Any,
    _workspace: Workspace,
    _parameters: SearchParameters,
    _actions: int,
    _rng: np.random.Generator,
) -> float:
    """0: a descent ends at the leaf (paper, section III-D)."""
    return 0.0


def random_rollout(
    arrays: Any,
    _bound_arrays: Any,
    workspace: Workspace,
    parameters: SearchParameters,
    actions: int,
    rng: np.random.Generator,
) -> float:
    """Template: the discounted return of some cycles with random actions; `workspace.state` is overwritten.

    The rollout of Silver & Veness (2010).
    """
    gained, weight = 0.0, 1.0
    for _ in range(parameters.rollout_cycles):
        action = below(rng, actions)
        _, reward = step(arrays, workspace.state, action, workspace.probabilities, rng)
        gained += weight * reward
        weight *= parameters.discount
    return gained


def greedy_rollout(
    arrays: Any,
    _bound_arrays: Any,
    workspace: Workspace,
    parameters: SearchParameters,
    actions: int,
    rng: np.random.Generator,
) -> float:
    """Template: the discounted return of some greedy cycles; `workspace.state` is overwritten.

    The rollout knows the sampled state, which a policy would not.
    """
    state, moved, probabilities = workspace.state, workspace.moved, workspace.probabilities
    gained, weight = 0.0, 1.0
    for _ in range(parameters.rollout_cycles):
        best, best_reward = 0, -np.inf
        for action in range(actions):
            expected = expected_reward(arrays, state, action, probabilities, moved)
            if expected > best_reward:
                best, best_reward = action, expected
        _, reward = step(arrays, state, best, probabilities, rng)
        gained += weight * reward
        weight *= parameters.discount
    return gained


def problem_bound(
    _arrays: Any,
    bound_arrays: Any,
    workspace: Workspace,
    _parameters: SearchParameters,
    _actions: int,
    _rng: np.random.Generator,
) -> float:
    """Template: the problem's bound of the state's value."""
    return bound(bound_arrays, workspace.state)

"""Rollouts in problems that forbid actions, that end, or that have a rollout policy of their own."""

from typing import Any

import numpy as np

from fatigue_planner.planners.pomcp.buffers import SearchParameters, Workspace
from fatigue_planner.pomdp.parts import bound, expected_reward, is_legal, is_terminal, rollout, step

# No action is legal.
NO_ACTION = -1


def choose(arrays: Any, workspace: Workspace, actions: int, rng: np.random.Generator) -> int:
    """Placeholder for the policy of the rollout."""
    raise NotImplementedError


def follow_policy(
    arrays: Any,
    _bound_arrays: Any,
    workspace: Workspace,
    parameters: SearchParameters,
    actions: int,
    rng: np.random.Generator,
) -> float:
    """Template: the discounted return of some cycles of a policy; `workspace.state` is overwritten.

    It ends with the task, and where the policy finds no action that is legal.
    """
    gained, weight = 0.0, 1.0
    for _ in range(parameters.rollout_cycles):
        if is_terminal(arrays, workspace.state):
            break
        action = choose(arrays, workspace, actions, rng)
        if action < 0 or action >= actions or not is_legal(arrays, workspace.state, action):
            break
        _, reward = step(arrays, workspace.state, action, workspace.probabilities, rng)
        gained += weight * reward
        weight *= parameters.discount
    return gained


def any_legal(arrays: Any, workspace: Workspace, actions: int, rng: np.random.Generator) -> int:
    """Template: one of the legal actions, each as likely as the others."""
    legal = 0
    for action in range(actions):
        legal += 1 if is_legal(arrays, workspace.state, action) else 0
    wanted = int(rng.random() * legal)
    for action in range(actions):
        if is_legal(arrays, workspace.state, action):
            if wanted == 0:
                return action
            wanted -= 1
    return NO_ACTION


def greediest_legal(arrays: Any, workspace: Workspace, actions: int, _rng: np.random.Generator) -> int:
    """Template: the legal action with the best expected reward; the first of several."""
    best, best_reward = NO_ACTION, -np.inf
    for action in range(actions):
        if is_legal(arrays, workspace.state, action):
            expected = expected_reward(arrays, workspace.state, action, workspace.probabilities, workspace.moved)
            if best == NO_ACTION or expected > best_reward:
                best, best_reward = action, expected
    return best


def of_the_problem(arrays: Any, workspace: Workspace, _actions: int, rng: np.random.Generator) -> int:
    """Template: what the problem's own rollout policy does."""
    return int(rollout(arrays, workspace.state, rng))


def bound_until_the_end(
    arrays: Any,
    bound_arrays: Any,
    workspace: Workspace,
    _parameters: SearchParameters,
    _actions: int,
    _rng: np.random.Generator,
) -> float:
    """Template: the problem's bound of the state's value; after the end there is nothing to gain."""
    return 0.0 if is_terminal(arrays, workspace.state) else float(bound(bound_arrays, workspace.state))

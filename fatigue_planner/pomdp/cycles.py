"""Cycles of many runs at once, driven by uniform draws that are given: compiled for each problem."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined, specialised
from fatigue_planner.pomdp.parts import advance, draw, observation_probability, outcome_probabilities
from fatigue_planner.pomdp.problem import Pomdp, Vector

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

N_OBSERVATIONS = 0


def live_cycle(
    arrays: Any, state: Vector, action: int, scratch: Vector, outcome_draw: float, observation_draw: float
) -> tuple[int, int, float]:
    """Template: move `state` in place by a cycle; its outcome, what is observed, and the reward.

    The draws are uniform in [0, 1); `scratch` (K,).
    """
    outcome_probabilities(arrays, state, action, scratch)
    outcome = draw(scratch, outcome_draw)
    reward = advance(arrays, state, action, outcome)
    last = 0
    for observation in range(N_OBSERVATIONS):
        probability = observation_probability(arrays, state, action, outcome, observation)
        if probability > 0:
            observation_draw -= probability
            if observation_draw < 0:
                return outcome, observation, reward
            last = observation
    return outcome, last, reward


def step_all(
    arrays: Any,
    runs: Numbers,
    states: Array,
    actions: Numbers,
    draws: Array,
    cycles: Numbers,
    n_outcomes: int,
    outcomes: Numbers,
    observations: Numbers,
    rewards: Vector,
) -> None:
    """Template: a cycle of those of n runs that `runs` lists; all but it and `states` (n, L) are (n,).

    draws (n, cycles, 2): of the outcome and of the observation; `cycles`, the number of the cycle, goes up by one.
    """
    scratch = np.empty(n_outcomes)
    for i in runs:
        now = draws[i, cycles[i]]
        outcomes[i], observations[i], rewards[i] = live_cycle(arrays, states[i], actions[i], scratch, now[0], now[1])
        cycles[i] += 1


def cycle_of(model: Pomdp) -> Any:
    """`live_cycle` for a problem, to be part of a template."""
    parts = {name: model.parts[name] for name in ("outcome_probabilities", "advance", "observation_probability")}
    return specialised(live_cycle, inlined, **parts, N_OBSERVATIONS=len(model.observations))


def stepper(model: Pomdp) -> Any:
    """`step_all` for a problem, compiled."""
    return specialised(step_all, live_cycle=cycle_of(model))

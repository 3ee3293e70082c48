"""The compiled functions of a problem as parts of kernels: placeholders, and templates for what is optional.

A kernel is a template: the names below stand in it for the problem's own functions (see `jit.specialised`).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined, inlined_for_any_problem

Vector = NDArray[np.float64]


@inlined
def draw(probabilities: Vector, uniform: float) -> int:
    """The index whose part of [0, 1) contains `uniform`; never one of probability 0."""
    last = 0
    for index in range(probabilities.size):
        if probabilities[index] > 0:
            uniform -= probabilities[index]
            if uniform < 0:
                return index
            last = index
    return last


def outcome_probabilities(arrays: Any, state: Vector, action: int, probabilities: Vector) -> None:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def advance(arrays: Any, state: Vector, action: int, outcome: int) -> float:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def observation_probability(arrays: Any, state: Vector, action: int, outcome: int, observation: Any) -> float:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def step(arrays: Any, state: Vector, action: int, scratch: Vector, rng: np.random.Generator) -> tuple[int, float]:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def expected_reward(arrays: Any, state: Vector, action: int, probabilities: Vector, moved: Vector) -> float:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def draw_observation(
    arrays: Any, state: Vector, action: int, outcome: int, observation: Vector, rng: np.random.Generator
) -> None:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def is_legal(arrays: Any, state: Vector, action: int) -> bool:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def is_terminal(arrays: Any, state: Vector) -> bool:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def rollout(arrays: Any, state: Vector, rng: np.random.Generator) -> int:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def prior(arrays: Any, state: Vector, action: int) -> tuple[float, float]:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def bound(bound_arrays: Any, state: Vector) -> float:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def mean_over_outcomes(arrays: Any, state: Vector, action: int, probabilities: Vector, moved: Vector) -> float:
    """Template: the expected reward, from the three functions."""
    outcome_probabilities(arrays, state, action, probabilities)
    expected = 0.0
    for outcome in range(probabilities.size):
        if probabilities[outcome] > 0:
            for j in range(state.size):
                moved[j] = state[j]
            expected += probabilities[outcome] * advance(arrays, moved, action, outcome)
    return expected


N_OBSERVATIONS = 0


def sample_step_from_parts(
    arrays: Any, state: Vector, action: int, scratch: Vector, rng: np.random.Generator
) -> tuple[int, float]:
    """Template: the generative model, from the three functions."""
    outcome_probabilities(arrays, state, action, scratch)
    outcome = draw(scratch, rng.random())
    reward = advance(arrays, state, action, outcome)
    uniform = rng.random()
    last = 0
    for observation in range(N_OBSERVATIONS):
        probability = observation_probability(arrays, state, action, outcome, observation)
        if probability > 0:
            uniform -= probability
            if uniform < 0:
                return observation, reward
            last = observation
    return last, reward


def sample_step_unseen(
    arrays: Any, state: Vector, action: int, scratch: Vector, rng: np.random.Generator
) -> tuple[int, float]:
    """Template: the same without an observation, for rollouts where observations are continuous."""
    outcome_probabilities(arrays, state, action, scratch)
    outcome = draw(scratch, rng.random())
    return 0, advance(arrays, state, action, outcome)


# Probabilities must sum to 1 within this.
ROUNDING = 0.0


def first_wrong(arrays: Any, states: NDArray[np.float64], action: int, actions: int, outcomes: int) -> int:
    """Template: the first of the states (n, L) with wrong probabilities for an action or, if it is -1, any; or -1."""
    probabilities, moved = np.empty(outcomes), np.empty(states.shape[1])
    for i in range(states.shape[0]):
        if not is_terminal(arrays, states[i]):
            for a in range(actions):
                if action in (-1, a) and is_legal(arrays, states[i], a):
                    outcome_probabilities(arrays, states[i], a, probabilities)
                    if is_wrong(probabilities) or sees_wrong(arrays, states[i], a, probabilities, moved):
                        return i
    return -1


def is_wrong(probabilities: Vector) -> bool:
    """Template: whether they are negative or do not sum to 1."""
    total = 0.0
    for probability in probabilities:
        if not probability >= 0:
            return True
        total += probability
    return not abs(total - 1) <= ROUNDING


def sees_wrong(arrays: Any, state: Vector, action: int, probabilities: Vector, moved: Vector) -> bool:
    """Template: whether after some outcome the probabilities of the observations are wrong."""
    for outcome in range(probabilities.size if N_OBSERVATIONS > 0 else 0):
        if probabilities[outcome] > 0:
            for j in range(moved.size):
                moved[j] = state[j]
            advance(arrays, moved, action, outcome)
            total = 0.0
            for observation in range(N_OBSERVATIONS):
                probability = observation_probability(arrays, moved, action, outcome, observation)
                if not probability >= 0:
                    return True
                total += probability
            if not abs(total - 1) <= ROUNDING:
                return True
    return False


# --- the three functions and their short cuts in a problem that ends: nothing happens after the end ----------------


def outcomes_until_the_end(arrays: Any, state: Vector, action: int, probabilities: Vector) -> None:
    """Template: after the end there is one outcome, the first."""
    if is_terminal(arrays, state):
        for outcome in range(probabilities.size):
            probabilities[outcome] = 1.0 if outcome == 0 else 0.0
    else:
        outcome_probabilities(arrays, state, action, probabilities)


def advance_until_the_end(arrays: Any, state: Vector, action: int, outcome: int) -> float:
    """Template: after the end no state changes and nothing is gained."""
    return 0.0 if is_terminal(arrays, state) else float(advance(arrays, state, action, outcome))


def reward_until_the_end(arrays: Any, state: Vector, action: int, probabilities: Vector, moved: Vector) -> float:
    """Template: the same for the expected reward."""
    if is_terminal(arrays, state):
        for outcome in range(probabilities.size):
            probabilities[outcome] = 1.0 if outcome == 0 else 0.0
        return 0.0
    return float(expected_reward(arrays, state, action, probabilities, moved))


def likelihood_of_going_on(arrays: Any, state: Vector, action: int, outcome: int, observation: Any) -> float:
    """Template: who is still asked for an action has not reached an end; so no such state remains in a belief."""
    if is_terminal(arrays, state):
        return 0.0
    return float(observation_probability(arrays, state, action, outcome, observation))


def legal_until_the_end(arrays: Any, state: Vector, action: int) -> bool:
    """Template: after the end nothing is forbidden, as nothing is done."""
    return bool(is_terminal(arrays, state) or is_legal(arrays, state, action))


@inlined_for_any_problem
def likelihood_of_outcome(_arrays: Any, _state: Vector, _action: int, outcome: int, likelihood: Vector) -> float:
    """Stands for the probability of an observation where the evidence is a likelihood of every outcome (K,)."""
    return float(likelihood[outcome])


@inlined_for_any_problem
def not_asked(_arrays: Any, _state: Vector, _action: int, _outcome: int, _observation: int) -> float:
    """Stands for the probability of an observation where observations are continuous, and none is asked for."""
    return 1.0


@inlined_for_any_problem
def legal_always(_arrays: Any, _state: Vector, _action: int) -> bool:
    """The rule of a problem that forbids nothing."""
    return True


@inlined_for_any_problem
def terminal_never(_arrays: Any, _state: Vector) -> bool:
    """The rule of a problem without end."""
    return False


@inlined_for_any_problem
def without_prior(_arrays: Any, _state: Vector, _action: int) -> tuple[float, float]:
    """Nothing is known of an action before it is tried."""
    return 0.0, 0.0

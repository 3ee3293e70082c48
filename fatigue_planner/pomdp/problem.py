"""What the planners know about a problem: a POMDP whose actions have finitely many outcomes.

A state is a vector of numbers. Choosing an action in a state has one of a few outcomes (for the fatigue
problem: the worker's motion preference); the outcome decides the next state and the reward, and the next
state, action and outcome decide how likely each observation is. Your own problem is an instance of
`Pomdp` with three compiled functions (examples/tiger.py).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import inlined, specialised

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# Probabilities must sum to 1 within this.
ROUNDING = 1e-9
# How many states of a belief are checked before a search: enough to find a wrong formula.
MAX_CHECKED = 20


@dataclass(frozen=True)
class Dynamics:
    """The compiled functions of a problem. `arrays` is the problem's NamedTuple of arrays and numbers.

    outcome_probabilities(arrays, state, action, probabilities)
        fills `probabilities` (K,) with P(outcome | state, action)
    advance(arrays, state, action, outcome) -> reward
        moves `state` in place
    observation_probability(arrays, state, action, outcome, observation) -> P(observation | ...)
        `state` is the one after the action
    step(arrays, state, action, scratch, rng) -> (observation, reward), optional
        moves `state` in place at random: a shortcut for the other three; `scratch` is (K,)
    expected_reward(arrays, state, action, probabilities, moved) -> reward, optional
        also a shortcut: the mean over the outcomes, whose probabilities it fills in; `moved` (L,) is scratch
    bound(bound_arrays, state) -> value, optional
        the value of the state, preferably a bound, for the leaves of searches (leaf value `bound`); `bound_arrays` is
        the problem's own, see `Pomdp.bound_arrays`

    >>> from tiger import PROBLEM  # examples/tiger.py
    >>> isinstance(PROBLEM.dynamics, fp.Dynamics)
    True
    """

    outcome_probabilities: Callable[..., Any]
    advance: Callable[..., Any]
    observation_probability: Callable[..., Any]
    step: Callable[..., Any] | None = None
    expected_reward: Callable[..., Any] | None = None
    bound: Callable[..., Any] | None = None

    def parts(self, n_observations: int) -> dict[str, Any]:
        """The names under which templates call these functions (see `jit.specialised`)."""
        basic = {
            "outcome_probabilities": self.outcome_probabilities,
            "advance": self.advance,
            "observation_probability": self.observation_probability,
        }
        step = self.step or specialised(sample_step_from_parts, inlined, **basic, N_OBSERVATIONS=n_observations)
        mean = self.expected_reward or specialised(mean_over_outcomes, inlined, **basic)
        return basic | {"step": step, "expected_reward": mean}


@dataclass(frozen=True)
class Pomdp:
    """A problem: the names of its actions, outcomes and observations, its discount and its functions.

    observation_reveals_outcome: the observation always tells the outcome (False is always correct).

    >>> from tiger import PROBLEM  # examples/tiger.py
    >>> isinstance(PROBLEM, fp.Pomdp), PROBLEM.actions
    (True, ('open left', 'open right', 'listen'))
    """

    actions: tuple[str, ...]
    outcomes: tuple[str, ...]
    observations: tuple[str, ...]
    discount: float
    arrays: Any
    dynamics: Dynamics
    observation_reveals_outcome: bool = field(default=False, kw_only=True)

    @cached_property
    def parts(self) -> dict[str, Any]:
        """The problem's functions by their names in templates."""
        return self.dynamics.parts(len(self.observations))

    @cached_property
    def bound_arrays(self) -> Any:
        """What `dynamics.bound` reads; computed when first asked for."""
        return None

    def check(self, action: int, observation: int = 0) -> None:
        """Raise IndexError for an index that the problem does not have: compiled code would not notice."""
        for what, index, names in (("action", action, self.actions), ("observation", observation, self.observations)):
            if not 0 <= index < len(names):
                raise IndexError(f"{what} {index}: the problem has {len(names)}, numbered from 0")

    def check_probabilities(self, states: Array) -> None:
        """Check the probabilities of outcomes and observations in some of the states (n, L), for every action.

        Raises ProblemError, naming state, action and sum, for probabilities that are negative or do not sum to 1.
        """
        for state in states[:MAX_CHECKED]:
            for action, name in enumerate(self.actions):
                probabilities = self.probabilities(state, action)
                _check_sum(probabilities, f"outcomes of action {name!r}", state)
                for outcome in np.flatnonzero(probabilities > 0):
                    moved, _ = self.transition(state, action, int(outcome))
                    seen = self.observation_probabilities(moved, action, int(outcome))
                    what = f"observations after action {name!r} and outcome {self.outcomes[outcome]!r}"
                    _check_sum(seen, what, moved)

    def probabilities(self, state: Vector, action: int) -> Vector:
        """P(outcome | state, action), (K,)."""
        probabilities = np.empty(len(self.outcomes))
        self.dynamics.outcome_probabilities(self.arrays, state, action, probabilities)
        return probabilities

    def transition(self, state: Vector, action: int, outcome: int) -> tuple[Vector, float]:
        """The state an outcome leads to, and its reward."""
        moved = state.copy()
        reward = float(self.dynamics.advance(self.arrays, moved, action, outcome))
        return moved, reward

    def sample_step(self, state: Vector, action: int, rng: np.random.Generator) -> tuple[Vector, int, float]:
        """Draw one cycle: the state it leads to, what is observed, and the reward."""
        self.check(action)
        moved = state.copy()
        observation, reward = self.parts["step"](self.arrays, moved, action, np.empty(len(self.outcomes)), rng)
        return moved, int(observation), float(reward)

    def observation_probabilities(self, state: Vector, action: int, outcome: int) -> Vector:
        """P(observation | state reached, action, outcome), (O,)."""
        see = self.dynamics.observation_probability
        return np.array([see(self.arrays, state, action, outcome, o) for o in range(len(self.observations))])


def _check_sum(probabilities: Vector, what: str, state: Vector) -> None:
    total = float(probabilities.sum())
    if not (probabilities >= 0).all() or not abs(total - 1) <= ROUNDING:
        raise ProblemError(
            f"the probabilities {probabilities.tolist()} of the {what} in state {state.tolist()} sum to {total:.6g}."
        )


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


def observation_probability(arrays: Any, state: Vector, action: int, outcome: int, observation: int) -> float:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def step(arrays: Any, state: Vector, action: int, scratch: Vector, rng: np.random.Generator) -> tuple[int, float]:
    """Placeholder in templates for the problem's own function."""
    raise NotImplementedError


def expected_reward(arrays: Any, state: Vector, action: int, probabilities: Vector, moved: Vector) -> float:
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

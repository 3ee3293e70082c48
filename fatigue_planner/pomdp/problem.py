"""What the planners know about a problem: a POMDP whose actions have finitely many outcomes.

A state is a vector of numbers. Choosing an action in a state has one of a few outcomes (for the fatigue
problem: the worker's motion preference); the outcome decides the next state and the reward, and the next
state, action and outcome decide how likely each observation is. Your own problem is an instance of
`Pomdp` with three compiled functions (examples/tiger.py), and more where they help (`Dynamics`).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import inlined, specialised
from fatigue_planner.pomdp import parts
from fatigue_planner.pomdp.dynamics import Dynamics
from fatigue_planner.pomdp.parts import (
    advance,
    draw,
    expected_reward,
    observation_probability,
    outcome_probabilities,
    step,
)
from fatigue_planner.pomdp.timing import AS_PLANNED, Pace
from fatigue_planner.pomdp.told import InTheUsersTerms, check_arrays, no_number

__all__ = [
    "Dynamics", "Observation", "Pomdp", "advance", "draw", "expected_reward", "observation_probability",
    "outcome_probabilities", "step",
]  # fmt: skip

Vector = NDArray[np.float64]
Array = NDArray[np.float64]
# What is observed: the index of an observation or, if observations are continuous, their numbers (W,).
Observation = int | Vector

# Probabilities must sum to 1 within this.
ROUNDING = 1e-9
# Likelihoods are scaled if the largest is as small as this, or as large as its inverse.
SMALL = 1e-100
# How many states of a belief are checked before a search: enough to find a wrong formula.
MAX_CHECKED = 20


@dataclass(frozen=True)
class Pomdp:
    """A problem: the names of its actions, outcomes and observations, its discount and its functions.

    observations: their names or, where they are continuous (`Dynamics.draw_observation`), those of the numbers that one
        consists of
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

    def __post_init__(self) -> None:
        """Raise ProblemError for what compiled code would go wrong with."""
        for what in ("actions", "outcomes", "observations"):
            names = getattr(self, what)
            if isinstance(names, str) or not names:
                raise ProblemError(f"{what}: {names!r} are no names; give a tuple of at least one.")
            object.__setattr__(self, what, tuple(names))
        if not 0 <= self.discount <= 1:
            raise ProblemError(f"discount: {self.discount!r}; it lies between 0 and 1.")
        check_arrays("arrays", self.arrays)

    # Whether its functions are the package's own: they need no check at every decision.
    is_trusted: ClassVar[bool] = False

    @cached_property
    def parts(self) -> dict[str, Any]:
        """The problem's functions by their names in templates."""
        return self.dynamics.parts(len(self.observations))

    @cached_property
    def belief_parts(self) -> dict[str, Any]:
        """Those that the update of a belief calls: a belief holds no state in which the task has ended."""
        return self._for_beliefs(self.dynamics.observation_probability)

    @cached_property
    def evidence_parts(self) -> dict[str, Any]:
        """The same where the evidence is no observation, but a likelihood of every outcome (see `Belief.weigh`)."""
        return self._for_beliefs(parts.likelihood_of_outcome)

    def _for_beliefs(self, observation_probability: Callable[..., Any]) -> dict[str, Any]:
        names = ("outcome_probabilities", "advance")
        chosen = {name: self.parts[name] for name in names} | {"observation_probability": observation_probability}
        if self.dynamics.is_terminal is not None:
            chosen["observation_probability"] = specialised(
                parts.likelihood_of_going_on,
                inlined,
                is_terminal=self.dynamics.is_terminal,
                observation_probability=observation_probability,
            )
        return chosen

    def evidence_arrays(self, share: float) -> Any:
        """What `evidence_parts` read for a cycle whose reaction took a share of the planned time (see `pace`)."""
        assert share == 1
        return self.arrays

    def pace(self, duration_s: float | None) -> Pace:
        """How a cycle of some duration went; None: as planned. Raises ProblemError if its cycles have no duration."""
        if duration_s is None:
            return AS_PLANNED
        raise ProblemError("duration_s: the problem does not say how long its cycles take.")

    def rested(self, states: Array, seconds: float) -> Array:
        """The states (n, L) after a rest. Raises ProblemError if the problem does not say what rest does."""
        raise ProblemError(f"rest of {seconds!r} s: the problem does not say what rest does to its states.")

    def check_likelihood(self, action: int, likelihood: ArrayLike) -> Vector:
        """The likelihood of every outcome (K,) as numbers of a size that can be multiplied; equal ones are 1.

        Raises IndexError for an action the problem does not have, ProblemError for what is no likelihood.
        """
        self.check(action)
        try:
            given = np.array(likelihood, float)
        except (TypeError, ValueError):
            raise ProblemError(f"likelihood: {likelihood!r} are no numbers.") from None
        if given.shape != (len(self.outcomes),):
            raise ProblemError(
                f"likelihood: has shape {given.shape}; give one number for each of {', '.join(self.outcomes)}."
            )
        if not (np.isfinite(given) & (given >= 0)).all() or not given.any():
            raise ProblemError(
                f"likelihood: {given.tolist()}; give finite numbers that are not negative, one of them positive."
            )
        largest = float(given.max())
        if (given == largest).all():
            return np.ones(given.size)
        return given if SMALL < largest < 1 / SMALL else given / largest

    @cached_property
    def bound_arrays(self) -> Any:
        """What `dynamics.bound` reads: `arrays`; a subclass may compute something else, when first asked for."""
        return self.arrays

    @property
    def is_continuous(self) -> bool:
        """Whether its observations are continuous."""
        return self.dynamics.draw_observation is not None

    @cached_property
    def told(self) -> InTheUsersTerms:
        """A context in which errors of the problem's functions are told in their author's terms, as ProblemError."""
        return InTheUsersTerms(self.dynamics.functions())

    def check(self, action: int, observation: Observation = 0) -> None:
        """Raise IndexError for an index that the problem does not have: compiled code would not notice."""
        if not isinstance(action, int | np.integer):
            raise IndexError(
                f"action {action!r}: actions are numbered from 0; {list(self.actions)}.index(...) is the number"
            )
        named = [("action", int(action), self.actions)]
        if isinstance(observation, int | np.integer):
            named += [("observation", int(observation), self.observations)]
        elif not self.is_continuous or np.shape(observation) != (len(self.observations),):
            raise IndexError(f"observation {observation!r}: the problem's are not such")
        for what, index, names in named:
            if not 0 <= index < len(names):
                raise IndexError(f"{what} {index}: the problem has {len(names)}, numbered from 0")

    def is_legal(self, state: Vector, action: int) -> bool:
        """Whether the state permits an action; where the task has ended, every one."""
        legal = self.dynamics.is_legal
        return legal is None or self.has_ended(state) or bool(legal(self.arrays, state, action))

    def has_ended(self, state: Vector) -> bool:
        """Whether the task has ended in this state."""
        ended = self.dynamics.is_terminal
        return ended is not None and bool(ended(self.arrays, state))

    def check_probabilities(self, states: Array, actions: Iterable[int] | None = None) -> None:
        """Check the probabilities of outcomes and observations in some of the states (n, L), for every action.

        Raises ProblemError, naming state, action and sum, for probabilities that are negative or do not sum to 1, and
        for functions that cannot be compiled.
        """
        with self.told:
            for state in states[:MAX_CHECKED]:
                for action in range(len(self.actions)) if actions is None else actions:
                    if not self.has_ended(state) and self.is_legal(state, action):
                        self._check_action(state, action)

    def check_again(self, states: Array, action: int = -1) -> None:
        """Check the probabilities before every use (for one action, or for all): compiled, as it is done so often.

        Raises ProblemError as `check_probabilities` does. The package's own problems are right.
        """
        if self.is_trusted:
            return
        if action < 0:
            states = states[:: -(-len(states) // MAX_CHECKED)]
        with self.told:
            wrong = self._first_wrong(self.arrays, states, action, len(self.actions), len(self.outcomes))
        if wrong >= 0:
            self.check_probabilities(states[wrong : wrong + 1], None if action < 0 else [action])

    @cached_property
    def _first_wrong(self) -> Callable[..., int]:
        functions = self.dynamics
        observed: dict[str, Any] = {
            "observation_probability": parts.not_asked if self.is_continuous else functions.observation_probability,
            "N_OBSERVATIONS": 0 if self.is_continuous else len(self.observations),
        }
        return specialised(
            parts.first_wrong,
            outcome_probabilities=functions.outcome_probabilities,
            is_legal=functions.is_legal or parts.legal_always,
            is_terminal=functions.is_terminal or parts.terminal_never,
            is_wrong=specialised(parts.is_wrong, ROUNDING=ROUNDING),
            sees_wrong=specialised(parts.sees_wrong, advance=functions.advance, **observed, ROUNDING=ROUNDING),
        )

    def _check_action(self, state: Vector, action: int) -> None:
        name = self.actions[action]
        probabilities = self.probabilities(state, action)
        _check_sum(probabilities, f"outcomes of action {name!r}", state)
        for outcome in np.flatnonzero(probabilities > 0):
            moved, _ = self.transition(state, action, int(outcome))
            what = f"after action {name!r} and outcome {self.outcomes[outcome]!r}"
            if self.is_continuous:
                self._check_density(moved, action, int(outcome), what)
            else:
                _check_sum(self.observation_probabilities(moved, action, int(outcome)), f"observations {what}", moved)

    def _check_density(self, moved: Vector, action: int, outcome: int, what: str) -> None:
        """A drawn observation must have a density."""
        seen = self._draw_observation(moved, action, outcome, np.random.default_rng(0))
        density = self.dynamics.observation_probability(self.arrays, moved, action, outcome, seen)
        if not 0 < density < np.inf:
            raise ProblemError(
                f"draw_observation draws {seen.tolist()} {what} in state {moved.tolist()}, where the density that "
                f"observation_probability gives is {density}: it must be positive and finite."
            )

    def probabilities(self, state: Vector, action: int) -> Vector:
        """P(outcome | state, action), (K,)."""
        probabilities = np.empty(len(self.outcomes))
        self.dynamics.outcome_probabilities(self.arrays, state, action, probabilities)
        return probabilities

    def transition(self, state: Vector, action: int, outcome: int) -> tuple[Vector, float]:
        """The state an outcome leads to, and its reward. Raises ProblemError if that is no number."""
        moved = state.copy()
        reward = self.dynamics.advance(self.arrays, moved, action, outcome)
        if not isinstance(reward, int | float | np.number) or np.isnan(reward):
            raise no_number("advance", self.dynamics.advance, "the reward, a number", reward)
        return moved, float(reward)

    def sample_step(self, state: Vector, action: int, rng: np.random.Generator) -> tuple[Vector, Any, float]:
        """Draw one cycle: the state it leads to, what is observed (an index, or numbers (W,)), and the reward.

        Raises ProblemError if the task has ended, if the state forbids the action, or for wrong probabilities.
        """
        self.check(action)
        if not isinstance(rng, np.random.Generator):
            raise ProblemError(f"rng: {rng!r} is no random generator; give np.random.default_rng(seed).")
        state = np.asarray(state, float)
        if not self.is_trusted:
            self._check_possible(state, action)
        if self.is_continuous:
            outcome = draw(self.probabilities(state, action), rng.random())
            moved, reward = self.transition(state, action, outcome)
            return moved, self._draw_observation(moved, action, outcome, rng), reward
        moved = state.copy()
        with self.told:
            observation, reward = self.parts["step"](self.arrays, moved, action, np.empty(len(self.outcomes)), rng)
        return moved, int(observation), float(reward)

    def _check_possible(self, state: Vector, action: int) -> None:
        if self.has_ended(state):
            raise ProblemError(f"the task has ended in state {state.tolist()}: nothing follows.")
        if not self.is_legal(state, action):
            raise ProblemError(f"state {state.tolist()} forbids action {self.actions[action]!r}.")
        self.check_probabilities(state[None], [action])

    def _draw_observation(self, state: Vector, action: int, outcome: int, rng: np.random.Generator) -> Vector:
        seen = np.full(len(self.observations), np.nan)
        draw_it = self.dynamics.draw_observation
        assert draw_it is not None
        draw_it(self.arrays, state, action, outcome, seen, rng)
        return seen

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

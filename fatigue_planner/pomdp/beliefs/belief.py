"""The base class of beliefs: weighted states of a problem, updated by what is done and seen."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import specialised
from fatigue_planner.pomdp.parts import is_legal, is_terminal, legal_always, terminal_never
from fatigue_planner.pomdp.problem import ROUNDING, Observation, Pomdp, Vector, expected_reward

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Belief(ABC):
    """States (n, L) of `model` and their probabilities (n,).

    surprised: the last observation was impossible under the model, so the belief was widened.

    >>> belief = scenario.initial_belief("prior", scenario.model, np.random.default_rng(0))
    >>> belief.model.actions, belief.weights.tolist()
    (('high', 'low'), [1.0])
    """

    model: Pomdp
    states: Array
    weights: Vector
    surprised: bool = False

    def __post_init__(self) -> None:
        """Raise ProblemError for states that are no table, and for weights that are not probabilities."""
        for name in ("states", "weights"):
            given = getattr(self, name)
            if not isinstance(given, np.ndarray) or given.dtype != np.float64:
                object.__setattr__(self, name, np.asarray(given, float))
        if self.states.ndim != 2:
            raise ProblemError(
                f"the belief's states have shape {self.states.shape}; give one row for each, such as [[0.0], [1.0]]."
            )
        if self.weights.shape != (len(self.states),):
            raise ProblemError(f"the belief has {len(self.states)} states and weights of shape {self.weights.shape}.")
        total = float(self.weights.sum())
        if not (self.weights >= 0).all() or not abs(total - 1) <= ROUNDING:
            raise ProblemError(f"the weights of the belief sum to {total:.6g}, not to 1, or some are negative.")

    @abstractmethod
    def update(self, action: int, observation: Observation, rng: np.random.Generator) -> "Belief":
        """The belief after an action and an observation. Works for every observation that the problem has.

        Raises IndexError for an action or observation that the problem does not have.
        """

    def predict(self, action: int, rng: np.random.Generator, *, duration_s: float | None = None) -> "Belief":
        """The belief after an action of which nothing was seen: every outcome is as likely as the model has it.

        See `weigh`, of which it is the case that all likelihoods are equal.
        """
        return self.weigh(action, np.ones(len(self.model.outcomes)), rng, duration_s=duration_s)

    def weigh(
        self, action: int, likelihood: ArrayLike, rng: np.random.Generator, *, duration_s: float | None = None
    ) -> "Belief":
        """The belief after an action and soft evidence: how likely what was sensed is, given each outcome, (K,).

        Only ratios count; the column P(o | u) of `recognition` says what the observation o does. Evidence for what the
        model rules out widens the belief, as in `update`. duration_s: how long the cycle took, if not as planned (see
        `pomdp.timing`).

        However many cycles it goes on, the belief does not grow, as that by `update` may.

        Raises IndexError for an action that the problem does not have, and ProblemError for what is no likelihood or
        duration, if the problem's cycles have none, or if a belief of this kind takes no soft evidence.
        """
        raise ProblemError(
            f"{type(self).__name__} has no `weigh`: it can take neither soft evidence nor a cycle that was not seen."
        )

    def rest(self, seconds: float) -> "Belief":
        """The belief after a pause: exact, for every possible worker's own rates. rest(a).rest(b) is rest(a + b).

        Raises ProblemError for what is no time, if the problem does not say what rest does, or if a belief of this kind
        knows no rest.
        """
        raise ProblemError(f"{type(self).__name__} has no `rest`: it knows nothing of pauses.")

    def warm_up(self) -> None:
        """Compile what `predict` and `weigh` will ever need, by trying it: seconds, where nothing is compiled yet."""
        self.predict(0, np.random.default_rng(0))

    def expected_rewards(self) -> Vector:
        """Expected reward of every action for one cycle, (A,); -inf where a possible state forbids it.

        Raises ProblemError if every action is forbidden.
        """
        model = self.model
        values = np.where(self.legal_actions(), 0.0, -np.inf)
        kernel = specialised(add_expected_rewards, expected_reward=model.parts["expected_reward"])
        with model.told:
            kernel(model.arrays, self.states, self.weights, len(model.outcomes), values)
        return values

    def legal_actions(self) -> NDArray[np.bool_]:
        """Which actions every possible state permits, (A,). Raises ProblemError if there is none."""
        model = self.model
        legal = np.ones(len(model.actions), bool)
        if model.dynamics.is_legal is not None:
            ended = model.dynamics.is_terminal or terminal_never
            with model.told:
                kernel = specialised(forbid, is_legal=model.dynamics.is_legal, is_terminal=ended)
                kernel(model.arrays, self.states, self.weights, legal)
            if not legal.any():
                raise ProblemError(
                    f"every action is forbidden in some state of the belief, such as {self.states[0].tolist()}."
                )
        return legal

    def going_on(self) -> Self:
        """The belief of who sees that the task has not ended. Raises ProblemError if it has in every state."""
        if self.model.dynamics.is_terminal is None:
            return self
        going = self._which(-1)
        if going.all():
            return self
        if not self.weights[going].any():
            raise ProblemError("the task has ended in every state of the belief: there is nothing to decide.")
        return self.among(going)

    def permitting(self, action: int) -> Self:
        """The belief of who has taken the action: no state that forbids it is possible, unless all do."""
        if self.model.dynamics.is_legal is None:
            return self
        legal = self._which(action)
        return self.among(legal) if self.weights[legal].any() and not legal.all() else self

    def _which(self, action: int) -> NDArray[np.bool_]:
        """Which states permit an action, where the task has ended, too; or for -1, in which the task has not ended."""
        legal, ended = self.model.dynamics.is_legal or legal_always, self.model.dynamics.is_terminal or terminal_never
        with self.model.told:
            kernel = specialised(mark, is_legal=legal, is_terminal=ended)
            return np.asarray(kernel(self.model.arrays, self.states, action))

    def among(self, chosen: NDArray[np.bool_]) -> Self:
        """The belief given that the state is one of the chosen (n,)."""
        weights = self.weights[chosen]
        return replace(self, states=self.states[chosen], weights=weights / weights.sum())


def add_expected_rewards(arrays: object, states: Array, weights: Vector, outcomes: int, values: Vector) -> None:
    """Template: add to `values` (A,) the expected reward of every action."""
    probabilities = np.empty(outcomes)
    moved = np.empty(states.shape[1])
    for action in range(values.size):
        for i in range(weights.size if values[action] == 0 else 0):
            values[action] += weights[i] * expected_reward(arrays, states[i], action, probabilities, moved)


def forbid(arrays: object, states: Array, weights: Vector, legal: NDArray[np.bool_]) -> None:
    """Template: clear `legal` (A,) for every action that a possible state forbids."""
    for i in range(weights.size):
        if weights[i] > 0 and not is_terminal(arrays, states[i]):
            for action in range(legal.size):
                legal[action] &= bool(is_legal(arrays, states[i], action))


def mark(arrays: object, states: Array, action: int) -> NDArray[np.bool_]:
    """Template: see `Belief._which`."""
    chosen = np.empty(states.shape[0], np.bool_)
    for i in range(chosen.size):
        ended = is_terminal(arrays, states[i])
        chosen[i] = not ended if action < 0 else ended or is_legal(arrays, states[i], action)
    return chosen

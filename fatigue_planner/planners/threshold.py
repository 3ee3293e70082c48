"""The policy `threshold`: reactive, it changes the action when a joint is too tired (Peternel et al. 2018)."""

import time
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import specialised
from fatigue_planner.planners.policy import Decision, Policy, PolicySettings, plain_decision
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.problem import Vector, advance, outcome_probabilities

# Two relieving actions whose fatigue differs by less than this part are the same; the cheaper one is taken.
ROUNDING = 1e-12
# The work names one level; the second one only keeps the robot from changing to and fro, so it is near. An assumption.
HYSTERESIS = 0.9


class ThresholdPolicy(Policy):
    """Keeps an action until the expected fatigue of some entry reaches a level; then spares all that are tired.

    It begins with the most ergonomic action of one cycle. An entry of the fatigue is tired from the fatigue threshold
    on until it has recovered to the recovery threshold. Whenever one becomes tired the robot changes to the action
    after whose next cycle the tired ones have the smallest expected sum of squares.
    """

    def __init__(self, settings: "ThresholdSettings") -> None:
        self._level, self._recovered = settings.levels()
        self._tired: NDArray[np.bool_] | None = None
        self._action = 0

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act. Raises ProblemError for problems without fatigue."""
        begin = time.perf_counter()
        if not isinstance(belief.model, FatiguePomdp):
            raise ProblemError("threshold: the problem has no fatigue.")
        fatigue = belief.weights @ belief.states[:, :-1]
        if self._tired is None:
            belief.model.check_probabilities(belief.states)
            self._tired = np.zeros(fatigue.size, bool)
            self._action = int(belief.expected_rewards().argmax())
        still = self._tired & (fatigue > self._recovered)
        reached = (fatigue >= self._level) & ~still
        self._tired = still | reached
        reason = f"no joint newly at a fatigue of {self._level:g}"
        if reached.any():
            self._action = self._relieving(belief, self._tired)
            reason = f"a joint reached a fatigue of {self._level:g}; this action spares those that are tired"
        unknown = np.full(len(belief.model.actions), np.nan)
        return plain_decision(self._action, unknown, 0, time.perf_counter() - begin, reason, belief)

    def _relieving(self, belief: Belief, tired: NDArray[np.bool_]) -> int:
        """The action after whose next cycle the tired entries have the least expected squares."""
        model = belief.model
        squares = np.zeros((len(model.actions), tired.size))
        parts = {name: model.parts[name] for name in ("outcome_probabilities", "advance")}
        specialised(add_squares, **parts)(model.arrays, belief.states, belief.weights, len(model.outcomes), squares)
        left = squares[:, tired].sum(axis=1)
        candidates = np.flatnonzero(left <= left.min() * (1 + ROUNDING))
        return int(candidates[belief.expected_rewards()[candidates].argmax()])


def add_squares(arrays: object, states: Array, weights: Vector, outcomes: int, squares: Array) -> None:
    """Template: add to `squares` (A, W) the expected squares of the fatigue after a cycle of every action."""
    probabilities = np.empty(outcomes)
    moved = np.empty(states.shape[1])
    for action in range(squares.shape[0]):
        for i in range(weights.size):
            outcome_probabilities(arrays, states[i], action, probabilities)
            for outcome in range(outcomes):
                for j in range(moved.size):
                    moved[j] = states[i, j]
                advance(arrays, moved, action, outcome)
                for j in range(squares.shape[1]):
                    squares[action, j] += weights[i] * probabilities[outcome] * moved[j] ** 2


class ThresholdSettings(PolicySettings):
    """Another action whenever a joint is too tired."""

    kind: Literal["threshold"] = Field(description="Another action whenever a joint's fatigue reaches a level.")
    fatigue_threshold: float = Field(
        gt=0,
        lt=1,
        description="Expected fatigue of an entry, as a fraction of its strength, from which on it counts as tired.",
    )
    recovery_threshold: float | None = Field(
        default=None,
        ge=0,
        lt=1,
        description="Fatigue, as a fraction of the strength, to which a tired entry must recover before it can call "
        "for another change. Default: 0.9 of the fatigue threshold.",
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.recovery_threshold is not None and self.recovery_threshold >= self.fatigue_threshold:
            raise ValueError(
                f"recovery_threshold = {self.recovery_threshold:g}: must be below the fatigue_threshold "
                f"({self.fatigue_threshold:g})"
            )
        return self

    def levels(self) -> tuple[float, float]:
        """The fatigue threshold and the recovery threshold."""
        recovered = self.recovery_threshold
        if recovered is None:
            recovered = HYSTERESIS * self.fatigue_threshold
        return self.fatigue_threshold, recovered

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return ThresholdPolicy(self)

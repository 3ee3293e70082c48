"""Policies that do not look ahead (paper, section IV-E), and their settings."""

import time
from typing import Any, Literal

import numpy as np
from pydantic import Field

from fatigue_planner.core.jit import specialised
from fatigue_planner.planners.policy import Counts, Decision, Policy, PolicySettings, Rule, Vector, plain_decision
from fatigue_planner.pomdp.beliefs.belief import Array, Belief, add_expected_rewards
from fatigue_planner.pomdp.problem import Pomdp


class RandomPolicy(Policy):
    """Any action, with equal probability, every cycle."""

    draws_at_random = True

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act."""
        begin = time.perf_counter()
        actions = len(belief.model.actions)
        legal = belief.going_on().legal_actions()
        action = int(rng.integers(actions)) if legal.all() else int(rng.choice(np.flatnonzero(legal)))
        return plain_decision(
            action, np.full(actions, np.nan), 0, time.perf_counter() - begin, "drawn at random", belief
        )

    def ahead(self, belief: Belief, n_cycles: int, rng: np.random.Generator) -> Counts:
        """See Policy.ahead: the draws of so many decisions."""
        return rng.integers(len(belief.model.actions), size=n_cycles)


class RandomSettings(PolicySettings):
    """Any action, with equal probability."""

    kind: Literal["random"] = Field(description="Any action, with equal probability.")

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return RandomPolicy()


class AlternatingPolicy(Policy):
    """The actions in turn, in the order of the experiment file."""

    def __init__(self) -> None:
        self._cycle = 0

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act."""
        begin = time.perf_counter()
        actions = len(belief.model.actions)
        legal = belief.going_on().legal_actions()
        while not legal[self._cycle % actions]:
            self._cycle += 1
        action = self._cycle % actions
        self._cycle += 1
        return plain_decision(action, np.full(actions, np.nan), 0, time.perf_counter() - begin, "next in turn", belief)

    def ahead(self, belief: Belief, n_cycles: int, rng: np.random.Generator) -> Counts:
        """See Policy.ahead."""
        return (self._cycle + np.arange(n_cycles)) % len(belief.model.actions)


class AlternatingSettings(PolicySettings):
    """The actions in turn."""

    kind: Literal["alternating"] = Field(description="The actions in turn.")

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return AlternatingPolicy()


class GreedyPolicy(Policy):
    """The action with the lowest expected fatigue cost after one cycle; ties go to the first."""

    def __init__(self) -> None:
        self._checked = False

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act."""
        begin = time.perf_counter()
        if not self._checked:
            belief.model.check_probabilities(belief.states)
            self._checked = True
        else:
            belief.model.check_again(belief.states)
        values = belief.going_on().expected_rewards()
        duration_s = time.perf_counter() - begin
        return plain_decision(int(values.argmax()), values, 1, duration_s, "best expected reward of one cycle", belief)

    def rule(self) -> Rule:
        """See Policy.rule."""
        return Rule(_greedy_choice, lambda belief: (np.zeros(len(belief.model.actions)), len(belief.model.outcomes)))


def _greedy_choice(model: Pomdp) -> Any:
    rewards = specialised(add_expected_rewards, expected_reward=model.parts["expected_reward"])
    return specialised(choose_greedy, add_expected_rewards=rewards)


def choose_greedy(arrays: Any, memory: Any, states: Array, weights: Vector, _rng: np.random.Generator) -> int:
    """Template: the action that GreedyPolicy takes; memory: values (A,), and the number of outcomes."""
    values, outcomes = memory
    values[:] = 0.0
    add_expected_rewards(arrays, states, weights, outcomes, values)
    return int(np.argmax(values))


class GreedySettings(PolicySettings):
    """The lowest expected cost after one cycle."""

    kind: Literal["greedy"] = Field(description="The action with the lowest expected cost after one cycle.")

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return GreedyPolicy()

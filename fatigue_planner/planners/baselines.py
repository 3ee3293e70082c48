"""Policies that do not look ahead (paper, section IV-E), and their settings."""

import time
from typing import Literal

import numpy as np
from pydantic import Field

from fatigue_planner.planners.policy import Decision, Policy, PolicySettings, plain_decision
from fatigue_planner.pomdp.beliefs.belief import Belief


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


class GreedySettings(PolicySettings):
    """The lowest expected cost after one cycle."""

    kind: Literal["greedy"] = Field(description="The action with the lowest expected cost after one cycle.")

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return GreedyPolicy()

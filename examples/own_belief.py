"""A belief of your own: only the most probable states, for when the exact set would grow too large.

As a plug-in (`fatplan benchmark mine.yaml --plugin examples/own_belief.py`) an experiment file can name it:
`belief: {kind: likeliest, count: 50}`.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import Field

import fatigue_planner as fp


@dataclass(frozen=True)
class LikeliestBelief(fp.ExactBelief):
    """The exact belief, of which the `count` most probable states are kept."""

    count: int = 1

    def update(self, action: int, observation: int, rng: np.random.Generator) -> "LikeliestBelief":
        """See Belief.update."""
        exact = super().update(action, observation, rng)
        kept = np.argsort(-exact.weights, kind="stable")[: self.count]
        weights = exact.weights[kept] / exact.weights[kept].sum()
        return LikeliestBelief(exact.model, exact.states[kept], weights, exact.surprised, self.count)


@fp.register
class LikeliestSettings(fp.BeliefSettings):
    """Settings of LikeliestBelief."""

    kind: Literal["likeliest"]
    count: int = Field(ge=1, le=1000, description="How many states are kept.")

    def build(self, model, states, weights, prior, rng) -> fp.Belief:
        """See BeliefSettings.build; the hidden worker is taken for the average one."""
        return LikeliestBelief(model, states, weights, count=self.count)

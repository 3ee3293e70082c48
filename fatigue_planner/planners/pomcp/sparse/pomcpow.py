"""POMCPOW (Sunberg & Kochenderfer 2018): the search for continuous or very many observations."""

from typing import Literal, Self

from pydantic import Field, model_validator

from fatigue_planner.planners.policy import Policy, PolicySettings
from fatigue_planner.planners.pomcp.kernels import LEAF_VALUE, ROLLOUT_CYCLES, LeafValueName
from fatigue_planner.planners.pomcp.sparse.policy import Search, SparsePolicy


class PomcpowSettings(PolicySettings):
    """POMCP with double progressive widening and weighted beliefs in its nodes."""

    kind: Literal["pomcpow"] = Field(
        description="Monte-Carlo tree search that samples observations and keeps a weighted belief in every node "
        "(POMCPOW): for continuous or very many observations."
    )
    exploration_constant: float = Field(ge=0, le=1e9, description="Constant c of UCB1; the unit is that of the return.")
    leaf_value: LeafValueName = Field(default="random_rollout", description=LEAF_VALUE)
    rollout_cycles: int = Field(default=20, ge=1, le=10_000, description=ROLLOUT_CYCLES)
    observations_k: float = Field(
        default=5.0,
        gt=0,
        le=1e6,
        description="Factor k of the widening, without unit: below an action tried N times at most k N^alpha "
        "observations and one.",
    )
    observations_alpha: float = Field(
        default=0.1, ge=0, le=1, description="Exponent alpha of the widening of the observations, without unit."
    )
    actions_k: float = Field(
        default=1e6,
        ge=1,
        le=1e6,
        description="Factor k of the widening of the actions, without unit: a node visited N times considers the first "
        "k N^alpha of its legal actions, in their order.",
    )
    actions_alpha: float = Field(
        default=0.0, ge=0, le=1, description="Exponent alpha of the widening of the actions, without unit."
    )
    descents: int | None = Field(
        default=None,
        ge=1,
        le=1_000_000,
        description="Budget of a decision: descents of the tree. Give this or seconds.",
    )
    seconds: float | None = Field(
        default=None, gt=0, le=3600, description="Budget of a decision: planning time in s. Give this or descents."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.descents is None) == (self.seconds is None):
            raise ValueError("needs a budget: either descents or seconds")
        return self

    def build(self) -> Policy:
        """See PolicySettings.build."""
        constants = self.actions_k, self.actions_alpha, self.observations_k, self.observations_alpha
        leaf = self.leaf_value, self.rollout_cycles
        return SparsePolicy(
            Search("mean", "fixed", self.exploration_constant, *leaf, self.descents, self.seconds, constants)
        )

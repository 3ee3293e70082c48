"""The settings of every policy, as an experiment file gives them."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from fatigue_planner.core.settings import Settings
from fatigue_planner.planners.pomcp.kernels import BackupName, ExplorationName, LeafValueName
from fatigue_planner.pomdp.scenario import Knowledge

_LEAF_VALUE = (
    "What a path is worth beyond its last cycle: nothing (none), a rollout of random or greedy actions, or the proven "
    "bound of the cost to come (bound)."
)
_DEPTH = "How many cycles are looked ahead."
_ROLLOUT_CYCLES = "Length of a rollout in cycles."


class PolicySettingsBase(Settings):
    """What all policies have in common."""

    knows: Knowledge = Field(
        default="prior",
        description="What the policy knows of a worker with hidden parameters: their distribution (prior), the average "
        "worker, taken for the true one (average), or the true ones (truth).",
    )


class RandomSettings(PolicySettingsBase):
    """Any action, with equal probability."""

    kind: Literal["random"] = Field(description="Any action, with equal probability.")


class AlternatingSettings(PolicySettingsBase):
    """The actions in turn."""

    kind: Literal["alternating"] = Field(description="The actions in turn.")


class GreedySettings(PolicySettingsBase):
    """The lowest expected cost after one cycle."""

    kind: Literal["greedy"] = Field(description="The action with the lowest expected cost after one cycle.")


class PomcpSettings(PolicySettingsBase):
    """Monte-Carlo tree search: backup `mean` is POMCP, `max` POMCP-Max; it ends after `descents` or `seconds`."""

    kind: Literal["pomcp"] = Field(description="Monte-Carlo tree search over beliefs.")
    backup: BackupName = Field(
        description="How an action's value follows from its descents: their mean (POMCP), the best action below (max: "
        "POMCP-Max), or exact expectations."
    )
    exploration_constant: float = Field(
        ge=0,
        le=1e9,
        description="Constant c of UCB1; the unit is that of the return, or none if exploration is scaled.",
    )
    exploration: ExplorationName = Field(
        default="fixed",
        description="Whether c is taken as it is (fixed) or times the spread of the returns met so far (scaled).",
    )
    leaf_value: LeafValueName = Field(default="none", description=_LEAF_VALUE)
    rollout_cycles: int = Field(default=20, ge=1, le=10_000, description=_ROLLOUT_CYCLES)
    descents: int | None = Field(
        default=None,
        ge=1,
        le=1_000_000,
        description="Budget of a decision: descents of the tree, at least one per action. Give this or seconds.",
    )
    seconds: float | None = Field(
        default=None, gt=0, le=3600, description="Budget of a decision: planning time in s. Give this or descents."
    )
    reuse_tree: bool = Field(
        default=False, description="Whether the next decision goes on with the part of the tree that came true."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.descents is None) == (self.seconds is None):
            raise ValueError("needs a budget: either descents or seconds")
        return self


class LookaheadSettings(PolicySettingsBase):
    """Full-width expectimax over the belief to a depth in cycles."""

    kind: Literal["lookahead"] = Field(description="Exact lookahead over everything that may happen.")
    depth: int = Field(ge=1, le=30, description=_DEPTH)
    leaf_value: LeafValueName = Field(default="none", description=_LEAF_VALUE)
    rollout_cycles: int = Field(default=20, ge=1, le=10_000, description=_ROLLOUT_CYCLES)


ReferenceLeafValue = Literal["none", "greedy_rollout", "bound"]


class ReferenceSettings(Settings):
    """The lookahead that `--regret` measures decisions against; it knows the prior of a hidden worker."""

    kind: Literal["lookahead"] = Field(description="Exact lookahead over everything that may happen.")
    depth: int = Field(ge=1, le=30, description=_DEPTH)
    # greedy_rollout only where nothing is left to chance: the best of noisy values is too good
    leaf_value: ReferenceLeafValue = Field(
        default="none",
        description="What a path is worth beyond its last cycle: nothing (none), a rollout of greedy actions, only "
        "where nothing is left to chance (greedy_rollout), or the proven bound of the cost to come (bound).",
    )
    rollout_cycles: int = Field(default=20, ge=1, le=10_000, description=_ROLLOUT_CYCLES)


PolicySettings = Annotated[
    RandomSettings | AlternatingSettings | GreedySettings | PomcpSettings | LookaheadSettings,
    Field(discriminator="kind"),
]

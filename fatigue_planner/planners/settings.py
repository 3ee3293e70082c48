"""The settings of every policy, as an experiment file gives them."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from fatigue_planner.core.settings import Settings
from fatigue_planner.planners.pomcp.kernels import BackupName, ExplorationName, LeafValueName
from fatigue_planner.pomdp.scenario import Knowledge


class PolicySettingsBase(Settings):
    """What all have: `knows` says what the policy knows of a worker with hidden parameters.

    prior: their distribution; average: takes the average worker for the true one; truth: knows him.
    """

    knows: Knowledge = "prior"


class RandomSettings(PolicySettingsBase):
    """Any action, with equal probability."""

    kind: Literal["random"]


class AlternatingSettings(PolicySettingsBase):
    """The actions in turn."""

    kind: Literal["alternating"]


class GreedySettings(PolicySettingsBase):
    """The lowest expected cost after one cycle."""

    kind: Literal["greedy"]


class PomcpSettings(PolicySettingsBase):
    """Monte-Carlo tree search: backup `mean` is POMCP, `max` POMCP-Max; it ends after `descents` or `seconds`."""

    kind: Literal["pomcp"]
    backup: BackupName
    exploration_constant: float = Field(ge=0, le=1e9)
    exploration: ExplorationName = "fixed"
    leaf_value: LeafValueName = "none"
    rollout_cycles: int = Field(default=20, ge=1, le=10_000)
    descents: int | None = Field(default=None, ge=1, le=1_000_000)
    seconds: float | None = Field(default=None, gt=0, le=3600)
    reuse_tree: bool = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.descents is None) == (self.seconds is None):
            raise ValueError("needs a budget: either descents or seconds")
        return self


class LookaheadSettings(PolicySettingsBase):
    """Full-width expectimax over the belief to a depth in cycles."""

    kind: Literal["lookahead"]
    depth: int = Field(ge=1, le=30)
    leaf_value: LeafValueName = "none"
    rollout_cycles: int = Field(default=20, ge=1, le=10_000)


ReferenceLeafValue = Literal["none", "greedy_rollout", "bound"]


class ReferenceSettings(Settings):
    """The lookahead that `--regret` measures decisions against; it knows the prior of a hidden worker."""

    kind: Literal["lookahead"]
    depth: int = Field(ge=1, le=30)
    # greedy_rollout only where nothing is left to chance: the best of noisy values is too good
    leaf_value: ReferenceLeafValue = "none"
    rollout_cycles: int = Field(default=20, ge=1, le=10_000)


PolicySettings = Annotated[
    RandomSettings | AlternatingSettings | GreedySettings | PomcpSettings | LookaheadSettings,
    Field(discriminator="kind"),
]

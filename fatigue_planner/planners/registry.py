"""The policies an experiment file can name: one settings class and one line each.

To add a policy: write it (see `policy.Policy`); here, describe its settings, name them in PolicySettings
and add a line to POLICY_KINDS.
"""

from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import Field

from fatigue_planner.planners.baselines import AlternatingPolicy, GreedyPolicy, RandomPolicy
from fatigue_planner.planners.policy import Policy
from fatigue_planner.planners.pomcp import PomcpPolicy
from fatigue_planner.pomdp.model import FatiguePomdp
from fatigue_planner.settings import Settings


class RandomSettings(Settings):
    """Any action, with equal probability."""

    kind: Literal["random"]


class AlternatingSettings(Settings):
    """The actions in turn."""

    kind: Literal["alternating"]


class GreedySettings(Settings):
    """The lowest expected cost after one cycle."""

    kind: Literal["greedy"]


class PomcpSettings(Settings):
    """Monte-Carlo tree search: backup `mean` is POMCP, `max` POMCP-Max."""

    kind: Literal["pomcp"]
    backup: Literal["mean", "max"]
    exploration_constant: float = Field(ge=0)
    descents: int = Field(ge=1, le=1_000_000)


PolicySettings = Annotated[
    RandomSettings | AlternatingSettings | GreedySettings | PomcpSettings, Field(discriminator="kind")
]

POLICY_KINDS: dict[str, Callable[[FatiguePomdp, Any], Policy]] = {
    "random": lambda model, _: RandomPolicy(model),
    "alternating": lambda model, _: AlternatingPolicy(model),
    "greedy": lambda model, _: GreedyPolicy(model),
    "pomcp": lambda model, s: PomcpPolicy(model, s.descents, s.exploration_constant, s.backup == "max"),
}


def build_policy(model: FatiguePomdp, settings: PolicySettings) -> Policy:
    """A fresh policy for one run."""
    return POLICY_KINDS[settings.kind](model, settings)

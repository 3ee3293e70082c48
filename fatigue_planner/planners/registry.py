"""The policies that an experiment file can name.

To add a policy: write it and its settings in a file (see `policy.Policy` and `policy.PolicySettings`), and add the
settings to KINDS here. From outside the package: `fatigue_planner.register` (see `core.plugins`).
"""

from typing import Annotated

from fatigue_planner.planners.baselines import AlternatingSettings, GreedySettings, RandomSettings
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.policy import POLICIES, PolicySettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings

KINDS = (RandomSettings, AlternatingSettings, GreedySettings, PomcpSettings, LookaheadSettings)
for kind in KINDS:
    POLICIES.add(kind)

# The settings of any policy.
AnyPolicy = Annotated[PolicySettings, POLICIES]

"""The policies that an experiment file can name, and the settings of a policy from its name or a mapping.

To add a policy: write it and its settings in a file (see `policy.Policy` and `policy.PolicySettings`), and add the
settings to KINDS here. From outside the package: `fatigue_planner.register` (see `core.plugins`).
"""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import TypeAdapter, ValidationError

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.planners.agent import AgentSettings
from fatigue_planner.planners.baselines import AlternatingSettings, GreedySettings, RandomSettings
from fatigue_planner.planners.fixed import FixedSettings
from fatigue_planner.planners.lookahead import LookaheadSettings
from fatigue_planner.planners.periodic import PeriodicSettings
from fatigue_planner.planners.policy import POLICIES, PolicySettings
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.planners.pomcp.sparse.pomcpow import PomcpowSettings
from fatigue_planner.planners.robust_periodic import RobustPeriodicSettings
from fatigue_planner.planners.threshold import ThresholdSettings

KINDS = (
    RandomSettings, AlternatingSettings, GreedySettings, FixedSettings, PeriodicSettings, RobustPeriodicSettings,
    ThresholdSettings, PomcpSettings, PomcpowSettings, LookaheadSettings, AgentSettings,
)  # fmt: skip
for kind in KINDS:
    POLICIES.add(kind)

# The settings of any policy.
AnyPolicy = Annotated[PolicySettings, POLICIES]
_ANY_POLICY: TypeAdapter[PolicySettings] = TypeAdapter(AnyPolicy)


def policy(settings: str | Mapping[str, Any] | PolicySettings) -> PolicySettings:
    """The settings of a policy from its kind, or from a mapping such as an experiment file has.

    Raises SelectionError with what is wrong.

    >>> fp.policy("greedy")
    GreedySettings(kind='greedy', knows='prior')
    >>> fp.policy({"kind": "pomcp", "backup": "max", "exploration_constant": 0.1, "descents": 500}).descents
    500
    """
    if isinstance(settings, PolicySettings):
        return settings
    content = {"kind": settings} if isinstance(settings, str) else dict(settings)
    try:
        return _ANY_POLICY.validate_python(content, strict=True)
    except ValidationError as error:
        messages = "; ".join(
            f"{'.'.join(map(str, detail['loc']))}: {detail['msg']}" for detail in error.errors(include_url=False)
        )
        raise SelectionError(f"policy {content}: {messages}.") from error

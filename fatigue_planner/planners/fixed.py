"""The policy `fixed`: always the same action."""

from typing import Literal

from pydantic import Field

from fatigue_planner.core.settings import Name
from fatigue_planner.planners.policy import Policy, PolicySettings
from fatigue_planner.planners.schedules.policy import SchedulePolicy, numbers_of
from fatigue_planner.planners.schedules.search import Plan
from fatigue_planner.pomdp.beliefs.belief import Belief


class FixedPolicy(SchedulePolicy):
    """One action for ever; without a name the most ergonomic one, which costs least in the first cycle."""

    def __init__(self, action: str | None) -> None:
        super().__init__()
        self._action = action

    def schedule(self, belief: Belief) -> Plan:
        """See SchedulePolicy.schedule. Raises SelectionError if the problem has no such action."""
        if self._action is not None:
            return numbers_of((self._action,), belief)
        belief.model.check_probabilities(belief.states)
        return (int(belief.expected_rewards().argmax()),)


class FixedSettings(PolicySettings):
    """Always the same action."""

    kind: Literal["fixed"] = Field(description="Always the same action.")
    action: Name | None = Field(
        default=None,
        description="The action, by name. Default: the most ergonomic one, that with the lowest expected cost of the "
        "first cycle, as in the works that the paper cites as [3] and [10].",
    )

    def actions_named(self) -> dict[str, tuple[str, ...]]:
        """See PolicySettings.actions_named."""
        return {} if self.action is None else {"action": (self.action,)}

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return FixedPolicy(self.action)

"""The policy `periodic`: a schedule, given or the best one."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from fatigue_planner.core.settings import Name
from fatigue_planner.planners.policy import Policy, PolicySettings
from fatigue_planner.planners.schedules.policy import SchedulePolicy, best_schedule_for, numbers_of
from fatigue_planner.planners.schedules.search import LONGEST, Plan
from fatigue_planner.pomdp.beliefs.belief import Belief

MAX_SEQUENCE = 1000
# The setting of every policy that searches for a schedule.
Longest = Annotated[
    int, Field(ge=1, le=LONGEST, description="The most cycles of the schedule that is searched for; 1: one action.")
]


class PeriodicPolicy(SchedulePolicy):
    """A sequence of actions for ever; without one the best for what is known before the first cycle."""

    def __init__(self, settings: "PeriodicSettings") -> None:
        super().__init__()
        self._settings = settings

    def schedule(self, belief: Belief) -> Plan:
        """See SchedulePolicy.schedule. Raises SelectionError if the problem has no such action."""
        if self._settings.sequence is not None:
            return numbers_of(self._settings.sequence, belief)
        belief.model.check_probabilities(belief.states)
        return best_schedule_for(belief, self._settings.longest).actions


class PeriodicSettings(PolicySettings):
    """A schedule that is repeated for ever."""

    kind: Literal["periodic"] = Field(description="A schedule: a sequence of actions that is repeated for ever.")
    sequence: Annotated[tuple[Name, ...], Field(min_length=1, max_length=MAX_SEQUENCE)] | None = Field(
        default=None,
        description="The actions by name, in order. Default: the schedule with the lowest expected discounted cost, "
        "found by search.",
    )
    longest: Longest = LONGEST

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.sequence is not None and "longest" in self.model_fields_set:
            raise ValueError("longest: is for a schedule that is searched for; leave it out, or the sequence")
        return self

    def actions_named(self) -> dict[str, tuple[str, ...]]:
        """See PolicySettings.actions_named."""
        return {} if self.sequence is None else {"sequence": self.sequence}

    def plans_endlessly(self) -> bool:
        """See PolicySettings.plans_endlessly."""
        return self.sequence is None

    def build(self) -> Policy:
        """See PolicySettings.build."""
        return PeriodicPolicy(self)

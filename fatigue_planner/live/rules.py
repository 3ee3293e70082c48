"""By what a shift decides: a policy, when an answer is late, and when the schedule takes over; checked and compiled."""

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.live.events import Configured, Observed
from fatigue_planner.live.said import deadline, unseen_limit
from fatigue_planner.live.shift import Adviser, Shift
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.pomdp.scenario import Scenario

DEFAULT_POLICY: dict[str, Any] = {"kind": "lookahead", "depth": 2, "leaf_value": "bound"}
# After so many cycles of which nothing was seen, the belief says little: the schedule decides.
UNSEEN_LIMIT = 20


@dataclass(frozen=True)
class Rules:
    """What decides from a cycle on: `adviser` answers, `for_table` prepares answers, for policies have memory."""

    cycle: int
    settings: PolicySettings
    deadline_s: float
    unseen_limit: int
    safe_action: int
    adviser: Adviser
    for_table: Adviser

    def event(self) -> Configured:
        """As the journal keeps it."""
        return Configured(
            cycle=self.cycle,
            policy=json.loads(self.settings.model_dump_json(exclude_unset=True)),
            policy_sources=self.settings.sources(),
            deadline_s=self.deadline_s,
            unseen_limit=self.unseen_limit,
        )


def from_json(policy: Any) -> Any:
    """A policy's settings with tuples where JSON has lists."""
    if isinstance(policy, Mapping):
        return {key: from_json(value) for key, value in policy.items()}
    return tuple(from_json(value) for value in policy) if isinstance(policy, list) else policy


def made(
    scenario: Scenario, settings: PolicySettings, deadline_s: object, limit: object, safe_action: int, cycle: int
) -> Rules:
    """Rules that were tried. Raises SelectionError for what cannot decide beside a robot, or not in time."""
    deadline_s, limit = deadline(deadline_s), unseen_limit(limit)
    adviser, for_table = (Adviser(scenario, settings, safe_action) for _ in range(2))
    warm_up(Shift(scenario, settings, ""), adviser, deadline_s)
    return Rules(cycle, settings, deadline_s, limit, safe_action, adviser, for_table)


def warm_up(shift: Shift, adviser: Adviser, deadline_s: float) -> None:
    """Compile everything by running it on a shift that is thrown away.

    Raises SelectionError if a decision takes longer than the deadline even then.
    """
    model = shift.scenario.model
    shift.belief.warm_up()
    times_s: dict[tuple[str | None, str], float] = {}  # of the fastest turn: another program may disturb the others
    for turn in range(3):
        for seen in (None, *model.observations):
            for action in model.actions:
                event = Observed(cycle=shift.cycle, executed=action, observation=seen, idle_s=60.0 * turn)
                shift.take(event)
                begin = time.perf_counter()
                adviser.choose(shift.belief, shift.cycle)
                took_s = time.perf_counter() - begin
                times_s[seen, action] = min(took_s, times_s.get((seen, action), took_s))
        even = dict.fromkeys(model.outcomes, 1.0)
        shift.take(Observed(cycle=shift.cycle, executed=model.actions[0], likelihood=even, duration_s=1.0))
    slowest_s = max(times_s.values())
    if slowest_s > deadline_s:
        raise SelectionError(
            f"the policy took {1000 * slowest_s:.0f} ms for a decision, more than deadline_s = {deadline_s:g}; choose "
            "one that looks less far ahead, or a later deadline."
        )

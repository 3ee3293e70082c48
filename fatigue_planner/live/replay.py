"""A shift that was begun is gone on with: the events of its journal are lived through again."""

from datetime import UTC, datetime
from pathlib import Path

from fatigue_planner.live.clock import Clock
from fatigue_planner.live.events import Configured, Decided, Executed, Input, Opened, Resumed
from fatigue_planner.live.journal_file import Stored
from fatigue_planner.live.opening import refuse
from fatigue_planner.live.rules import Rules, from_json, made
from fatigue_planner.live.standing import Standing
from fatigue_planner.planners.registry import policy


def replay(standing: Standing, events: list[Stored], clock: Clock, path: Path) -> None:
    """Stand where the journal's shift stands; its events begin with that of its opening.

    Raises OtherSituationError if a policy that was configured has changed.
    """
    origin = ""
    for stored in events:
        event = stored.event
        if isinstance(event, Opened | Resumed):
            origin = event.origin
        at_s = time_of(stored, origin, clock)
        if isinstance(event, Input):
            standing.go_on(event, at_s)
        elif isinstance(event, Decided):
            standing.decide(event)
        else:
            standing.account(event, at_s)
        if isinstance(event, Executed):
            standing.hear(event)
        elif isinstance(event, Configured):
            standing.coming = _as_before(event, standing, path)
            if event.cycle <= standing.shift.cycle:
                standing.rules = standing.coming


def last_origin(events: list[Stored]) -> str:
    """Where the clock of the program that wrote the last events counts from."""
    return [one.event.origin for one in events if isinstance(one.event, Opened | Resumed)][-1]


def time_of(stored: Stored, origin: str, clock: Clock) -> float:
    """When an event was, by this clock; after the machine has started anew, by the time of day."""
    if origin == clock.origin():
        return stored.seconds
    ago_s = (clock.utc() - datetime.fromisoformat(stored.utc).astimezone(UTC)).total_seconds()
    return clock.seconds() - max(ago_s, 0.0)


def _as_before(event: Configured, standing: Standing, path: Path) -> Rules:
    """The rules of an event of this journal. Raises OtherSituationError if a plug-in among them has changed."""
    settings = policy(from_json(event.policy))
    if settings.sources() != event.policy_sources:
        refuse([f"the policy from cycle {event.cycle} on"], path)
    limits = event.deadline_s, event.unseen_limit
    return made(standing.shift.scenario, settings, *limits, standing.rules.safe_action, event.cycle)

"""Journals written event by event, as if a shift had gone so."""

from collections.abc import Iterable
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

from fatigue_planner.core.provenance import versions
from fatigue_planner.live.events import FORMAT, Event, Opened
from fatigue_planner.live.journal_file import BEGINNING, Stored, append, body_of, connect, create
from fatigue_planner.planners.registry import policy
from fatigue_planner.pomdp.scenario import Scenario

MORNING = datetime(2026, 11, 28, 6, 0, tzinfo=UTC)


def opening(task: Scenario, origin: str = "boot", **other: object) -> Opened:
    """The first event of a shift in a scenario."""
    settings = policy({"kind": "lookahead", "depth": 2, "leaf_value": "bound"})
    content = {
        "format": FORMAT, "session": "5e55", "scenario": task.digest, "scenario_name": task.name,
        "actions": task.model.actions, "policy": settings.plain(), "policy_sources": {},
        "safe_action": task.model.actions[0], "deadline_s": 0.05, "versions": versions(), "origin": origin,
    }  # fmt: skip
    return Opened.model_validate(content | other)


def stored(events: Iterable[tuple[float, Event]], wall_off_s: float = 0.0) -> list[Stored]:
    """Events with the seconds at which they were."""
    return [
        Stored(number, 1000.0 + at_s, (MORNING + timedelta(seconds=at_s + wall_off_s)).isoformat(), event)
        for number, (at_s, event) in enumerate(events)
    ]


def write_journal(path: Path, events: Iterable[Stored], workers: dict[str, str] | None = None) -> Path:
    """A journal of events; workers: pseudonyms by random number."""
    create(path)
    with closing(connect(path)) as connection:
        append(connection, BEGINNING, [(one.number, one.seconds, one.utc, body_of(one.event)) for one in events])
        connection.executemany("INSERT INTO worker VALUES (?, ?)", (workers or {}).items())
    return path

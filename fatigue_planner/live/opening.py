"""Whether a journal's shift can go on: it must have been begun with the same situation, or a new segment begins."""

import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fatigue_planner.core.errors import OtherSituationError, SelectionError, listed
from fatigue_planner.core.files import digest_of, digest_of_package
from fatigue_planner.core.provenance import versions
from fatigue_planner.live.clock import Clock
from fatigue_planner.live.events import FORMAT, Advice, AlarmSettings, Opened, WorkerChanged
from fatigue_planner.live.journal_file import Stored
from fatigue_planner.live.rules import Rules, made
from fatigue_planner.live.shift import Shift
from fatigue_planner.planners.policy import PolicySettings
from fatigue_planner.planners.registry import policy as policy_settings
from fatigue_planner.pomdp.scenario import Scenario

# What decides in a shift, besides what the scenario's digest knows: files of the package.
SOURCES = ("core", "fatigue", "planners", "pomdp", "live/shift.py")
# What a part of the scenario comes from, by its key in `Scenario.fingerprint`.
MEANINGS = {
    "gain": "what a cycle does (its length, the motions, the worker's strengths or the fatigue law)",
    "offset": "what a cycle does (its length, the motions, the worker's strengths or the fatigue law)",
    "profiles": "what a cycle does (its length, the motions, the worker's strengths or the fatigue law)",
    "active_entries": "what a cycle does (its length, the motions, the worker's strengths or the fatigue law)",
    "expertise": "the worker's expertise",
    "even": "the worker's expertise",
    "observation": "the recognition",
    "observation_reveals_outcome": "the recognition",
    "n_actions": "the actions",
    "cost": "the cost",
    "discount": "the discount",
    "states": "the worker's initial fatigue",
    "weights": "the worker's initial fatigue",
    "prior": "what is hidden about the worker",
    "belief": "the belief",
}


def first_rules(
    scenario: Scenario,
    settings: PolicySettings,
    deadline_s: float,
    unseen_limit: int,
    safe_action: str | None,
) -> Rules:
    """By what a shift decides that begins with this, see `Session.open`. Raises SelectionError."""
    model = scenario.model
    if safe_action is None:
        safe = int(Shift(scenario, settings, "").belief.expected_rewards().argmax())
    elif safe_action in model.actions:
        safe = model.actions.index(safe_action)
    else:
        raise SelectionError(f"safe_action {safe_action!r}: should be one of {listed(model.actions)}.")
    return made(scenario, settings, deadline_s, unseen_limit, safe, 1)


def search_settings(
    search: str | Mapping[str, Any] | PolicySettings | None, settings: PolicySettings
) -> PolicySettings | None:
    """The policy that improves the decisions of another, if one does. Raises SelectionError."""
    searching = None if search is None else policy_settings(search)
    if searching is not None and searching.knows != settings.knows:
        raise SelectionError(f"search: should know what the policy does (knows: {settings.knows}).")
    return searching


def opening(
    scenario: Scenario,
    rules: Rules,
    clock: Clock,
    alarms: AlarmSettings,
    search: PolicySettings | None,
    experiment: str,
    cache: str,
) -> Opened:
    """The event of a shift that begins with this."""
    return Opened(
        format=FORMAT,
        session=secrets.token_hex(8),
        scenario=scenario.digest,
        scenario_name=scenario.name,
        actions=scenario.model.actions,
        policy=rules.settings.plain(),
        policy_sources=rules.settings.sources(),
        safe_action=scenario.model.actions[rules.safe_action],
        deadline_s=rules.deadline_s,
        unseen_limit=rules.unseen_limit,
        versions=versions(),
        origin=clock.origin(),
        alarms=alarms,
        rehearsal=clock.is_rehearsal(),
        parts=parts(scenario),
        planned_s=None if scenario.model.timing is None else scenario.model.timing.cycle_s,
        sources={name: digest_of_package(name) for name in SOURCES},
        search=None if search is None else search.plain(),
        experiment=experiment,
        cache=cache,
    )


def parts(scenario: Scenario) -> dict[str, str]:
    """By its key, the digest of everything that decides what happens in a scenario."""
    fingerprint = scenario.fingerprint()
    model = fingerprint.pop("model")
    arrays = model.pop("arrays")
    return {name: digest_of(value) for name, value in (fingerprint | model | arrays).items()}


def since_opened(events: list[Stored]) -> list[Stored]:
    """The events of the shift that was opened last; none in a new journal."""
    opened = [number for number, one in enumerate(events) if isinstance(one.event, Opened)]
    return events[opened[-1] :] if opened else []


def off_after(events: list[Stored]) -> tuple[str, ...]:
    """The workers of a segment who want no belief about them at its end."""
    off: set[str] = set()
    worker = ""
    for one in events:
        match one.event:
            case Opened(off=before):
                off.update(before)
            case WorkerChanged():
                worker = one.event.worker
            case Advice(on=on):
                (off.discard if on else off.add)(worker)
    return tuple(sorted(off))


def changes(before: Opened, now: Opened) -> list[str]:
    """What differs between two openings, in words; nothing if the shift of the one can go on with the other."""
    changed = [MEANINGS.get(name, name) for name in _different(before.parts, now.parts)]
    if before.scenario != now.scenario and not changed:
        changed = ["the scenario (task, worker, reactions or belief)"]
    whole = {
        "the actions": (before.actions, now.actions),
        "the policy": ((before.policy, before.policy_sources), (now.policy, now.policy_sources)),
        "the safe action": (before.safe_action, now.safe_action),
        "the clock (the machine's, or a rehearsal's)": (before.rehearsal, now.rehearsal),
    }
    changed += [name for name, (old, new) in whole.items() if old != new]
    changed += [f"the version of {name}" for name in _different(before.versions, now.versions)]
    changed += [f"the program's sources ({name})" for name in _different(before.sources, now.sources)]
    return list(dict.fromkeys(changed))


def _different(old: dict[str, str], new: dict[str, str]) -> list[str]:
    """The names of what is not the same in both; nothing where one does not say anything."""
    return [name for name in sorted(old | new) if old.get(name) != new.get(name)] if old and new else []


def refuse(changed: list[str], path: Path) -> None:
    """Raise OtherSituationError if something has changed."""
    if changed:
        raise OtherSituationError(
            f"{path}: the shift was begun with other settings: {listed(changed)} changed. Its belief cannot go on. "
            "Go on with what it was begun with, begin another journal, or accept the change (--accept), which begins "
            "a new segment in this one."
        )

"""What one change of a station would do: each is simulated and judged like the station itself."""

import math
from collections.abc import Iterator, Sequence

from fatigue_planner.ergonomics.result import Phrase
from fatigue_planner.station.assessment import Change
from fatigue_planner.station.examine import Examined
from fatigue_planner.station.schema import Hands, Place, Station

LIGHTER_KG, STEP_M = 1.0, 0.1
# Places above it are tried lower, those below it higher, in m: about the height of an elbow.
ELBOW_M = 1.0
# The lightest that a lighter tool can be, in kg; the nearest that a nearer place can be, in m.
LEAST_KG, LEAST_M = 0.1, 0.2

LIGHTER = "{tool} 1 kg lighter"
NEARER = "{place} 10 cm nearer"
LOWER = "{place} 10 cm lower"
HIGHER = "{place} 10 cm higher"
OTHER_HAND = "{operation} with the other hand"

OTHER: dict[Hands, Hands] = {"right": "left", "left": "right", "either": "other", "other": "either"}


def changed_stations(station: Station) -> list[tuple[Phrase, Station]]:
    """The station with one thing changed, and what that is."""
    return [*_lighter(station), *_moved(station), *_other_hand(station)]


def changes_of(phrases: Sequence[Phrase], before: Examined, after: Sequence[Examined]) -> tuple[Change, ...]:
    """What the changes do, the most helpful first: more places allowed, then more reached by all, then less fatigue."""
    found = [_change(phrase, before, each) for phrase, each in zip(phrases, after, strict=True)]
    return tuple(
        sorted(found, key=lambda each: (-each.allowed, -each.reached_by_all, -(each.saving_everywhere or 0.0)))
    )


def _change(phrase: Phrase, before: Examined, after: Examined) -> Change:
    best, was = after.best, before.best
    of_places = sum(len(each.places) for each in after.station.operations.values())
    saving = None if not was.cost or best.cost is None else 1 - best.cost / was.cost
    return Change(
        phrase,
        best.places,
        best.peak,
        best.cost,
        saving,
        _saving_everywhere(before, after),
        sum(not each.missed_by for each in after.summaries),
        of_places - len(best.excluded),
        of_places,
    )


def _saving_everywhere(before: Examined, after: Examined) -> float | None:
    costs = [(was.cost, now.cost) for was, now in zip(before.summaries, after.summaries, strict=True)]
    both = [(was, now) for was, now in costs if was is not None and now is not None]
    total = sum(was for was, _ in both)
    return 1 - sum(now for _, now in both) / total if total > 0 else None


def _lighter(station: Station) -> Iterator[tuple[Phrase, Station]]:
    used = [station.tool_at(name, place) for name, each in station.operations.items() for place in each.places]
    for name, tool in station.tools.items():
        if name in used and tool.mass_kg - LIGHTER_KG >= LEAST_KG:
            lighter = tool.model_copy(update={"mass_kg": round(tool.mass_kg - LIGHTER_KG, 4)})
            changed = station.model_copy(update={"tools": {**station.tools, name: lighter}})
            yield Phrase(LIGHTER, {"tool": name}), changed


def _moved(station: Station) -> Iterator[tuple[Phrase, Station]]:
    used = dict.fromkeys(place for each in station.operations.values() for place in each.places)
    for name in used:
        at = station.places[name]
        if at.map is not None:  # its neighbours on the map say it already
            continue
        ahead_m = math.hypot(at.x, at.y) if station.feet == "free" else at.x
        if ahead_m - STEP_M >= LEAST_M:
            part = 1 - STEP_M / ahead_m
            nearer = {"x": round(part * at.x, 4)} | ({"y": round(part * at.y, 4)} if station.feet == "free" else {})
            yield Phrase(NEARER, {"place": name}), _with(station, name, at, **nearer)
        if at.z > ELBOW_M:
            yield Phrase(LOWER, {"place": name}), _with(station, name, at, z=round(at.z - STEP_M, 4))
        else:
            yield Phrase(HIGHER, {"place": name}), _with(station, name, at, z=round(at.z + STEP_M, 4))


def _with(station: Station, name: str, at: Place, **moved: float) -> Station:
    return station.model_copy(update={"places": {**station.places, name: at.model_copy(update=moved)}})


def _other_hand(station: Station) -> Iterator[tuple[Phrase, Station]]:
    """The hand that works is the other one; where a worker faces the place, that of either is its mirror image."""
    for name, operation in station.operations.items():
        mirror = station.feet == "free" and operation.hand in ("either", "other")
        if (other := OTHER.get(operation.hand)) and not mirror:
            changed = operation.model_copy(update={"hand": other})
            new = station.model_copy(update={"operations": {**station.operations, name: changed}})
            yield Phrase(OTHER_HAND, {"operation": name}), new

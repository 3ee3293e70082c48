"""Which places are best: never one that a worker does not reach, or that a rule forbids."""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fatigue_planner.ergonomics.result import Level, Phrase
from fatigue_planner.station.assessment import (
    BestPlaces,
    Doing,
    Judged,
    Outcome,
    PlaceForWorker,
    PlaceSummary,
    Rule,
)
from fatigue_planner.station.cycles import Course, cost, peak, settled
from fatigue_planner.station.judging import repeated
from fatigue_planner.station.schema import Station

Places = tuple[str, ...]

NOT_REACHED = "{place} is left out: {workers} cannot work there"
FORBIDDEN = "{place} is left out: not acceptable for {worker} by {rules}"
_NEAREST = ("reached", "implausible", "too_weak", "missed")


class Considered(NamedTuple):
    """Places, one for every operation, with the mean cost of fatigue of all workers, and the highest fatigue of any."""

    places: Places
    cost: float
    peak: float


def places_for_workers(
    station: Station, outcomes: Sequence[Outcome], judged: Mapping[Doing, Judged]
) -> list[PlaceForWorker]:
    """The best way of every worker at every place: the least forbidden, and of these the least tiring."""
    found = []
    for operation, worker in itertools.product(station.operations, station.workers):
        for place in station.operations[operation].places:
            here = [each for each in outcomes if each.doing[:3] == (worker, operation, place)]
            usable = [each for each in here if each.doing in judged]
            if usable:
                best = min(usable, key=lambda each: (judged[each.doing].level, judged[each.doing].fatigue.cost))
                level = judged[best.doing].level
                found.append(PlaceForWorker(worker, operation, place, best.doing.way, level, best))
            else:
                found.append(PlaceForWorker(worker, operation, place, None, None, min(here, key=nearness)))
    return found


def nearness(outcome: Outcome) -> tuple[int, float]:
    """How near to being of use an outcome is, the least is nearest: by kind, then by m missed or s beyond limits."""
    kind = _NEAREST.index(outcome.kind)
    if outcome.kind == "missed":
        return kind, math.inf if outcome.missed_m is None else outcome.missed_m
    return kind, sum(each.seconds for each in outcome.breaches)


def summaries(station: Station, places: Sequence[PlaceForWorker], judged: Mapping[Doing, Judged]) -> list[PlaceSummary]:
    """Every place of every operation, for all workers."""
    found = []
    for operation, said in station.operations.items():
        for place in said.places:
            here = [each for each in places if (each.operation, each.place) == (operation, place)]
            reached = [judged[each.outcome.doing] for each in here if each.way is not None]
            level = max((each.level for each in reached), default=None)
            worst = [each for each in reached if each.level == level]
            tired = max(reached, key=lambda each: each.fatigue.peak, default=None)
            found.append(
                PlaceSummary(
                    operation,
                    place,
                    tuple(each.worker for each in here if each.way is not None),
                    tuple(each.worker for each in here if each.way is None),
                    level,
                    _most([rule for each in worst for rule in each.by]),
                    _most([rule for each in reached for rule in each.warned_by]),
                    tired.fatigue.peak if tired else None,
                    tired.fatigue.entry if tired else "",
                    float(np.mean([each.fatigue.cost for each in reached])) if reached else None,
                )
            )
    return found


def _most(rules: Sequence[Rule]) -> tuple[Rule, ...]:
    """Every rule once, with the most seconds."""
    found: dict[str, Rule] = {}
    for rule in rules:
        if rule.kind not in found or (rule.not_acceptable_s or 0) > (found[rule.kind].not_acceptable_s or 0):
            found[rule.kind] = rule
    return tuple(found.values())


Excluded = Mapping[tuple[str, str], Phrase]


def ranked(
    station: Station, places: Sequence[PlaceForWorker], excluded: Excluded, courses: Mapping[Doing, Course]
) -> list[Considered]:
    """The combinations of allowed places by their mean cost of fatigue, every worker in his or her best way."""
    allowed = [[p for p in said.places if (name, p) not in excluded] for name, said in station.operations.items()]
    ways = {(each.worker, each.operation, each.place): each.outcome.doing for each in places if each.way is not None}
    found = (considered(station, combination, ways, courses) for combination in itertools.product(*allowed))
    return sorted(found, key=lambda each: each.cost)


def best_of(station: Station, ranking: Sequence[Considered], excluded: Excluded, together: Phrase | None) -> BestPlaces:
    """What is recommended: the first of the ranking, beside the second."""
    if not ranking:
        return BestPlaces({}, None, None, {}, None, excluded, together)
    names, best, following = list(station.operations), ranking[0], ranking[1] if len(ranking) > 1 else None
    return BestPlaces(
        dict(zip(names, best.places, strict=True)),
        best.peak,
        best.cost,
        dict(zip(names, following.places, strict=True)) if following else {},
        following.cost / best.cost - 1 if following and best.cost > 0 else None,
        excluded,
    )


def considered(
    station: Station, places: Places, ways: Mapping[tuple[str, str, str], Doing], courses: Mapping[Doing, Course]
) -> Considered:
    """What the cycle with these places does to the workers; all of them reach them."""
    times = [said.times_per_cycle for said in station.operations.values()]
    costs, peaks = [], []
    for worker in station.workers:
        chosen = [ways[worker, name, place] for name, place in zip(station.operations, places, strict=True)]
        own = repeated([courses[doing] for doing in chosen], times)
        ends = settled(own, station.cycle.duration_s - station.busy_s())
        costs.append(cost(ends))
        peaks.append(peak(ends)[0])
    return Considered(places, float(np.mean(costs)), max(peaks))


def excluded(
    station: Station, places: Sequence[PlaceForWorker], judged: Mapping[Doing, Judged]
) -> dict[tuple[str, str], Phrase]:
    """The places that are none for all workers, and why: not reached by one, or forbidden to one in every way."""
    found = {}
    for operation, said in station.operations.items():
        for place in said.places:
            here = [each for each in places if (each.operation, each.place) == (operation, place)]
            missing = [each.worker for each in here if each.way is None]
            forbidden = [each for each in here if each.level == Level.NOT_ACCEPTABLE]
            if missing:
                found[operation, place] = Phrase(NOT_REACHED, {"place": place, "workers": ", ".join(missing)})
            elif forbidden:
                first = judged[forbidden[0].outcome.doing]
                titles = ", ".join(rule.title for rule in first.by)
                values = {"place": place, "worker": forbidden[0].worker, "rules": titles}
                found[operation, place] = Phrase(FORBIDDEN, values)
    return found

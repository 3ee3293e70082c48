"""A station's experiments within its limits: what breaks one is left out, so that no policy can choose it."""

import itertools
from collections.abc import Iterator, Mapping, Sequence, Set
from typing import NamedTuple

from fatigue_planner.ergonomics.result import Phrase
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.station.assessment import Doing, Outcome, RobotPlace
from fatigue_planner.station.experiments import Part, parts_of
from fatigue_planner.station.limits import Breach, Limit
from fatigue_planner.station.robot_reach import ruled_out
from fatigue_planner.station.schema import Station, Way

ALL_LEFT_OUT = "no place keeps the limits of the station in any way"
NOT_PRESENTED = "the robot can present no place that keeps the limits of the station in any way"


class BoundExperiment(NamedTuple):
    """An experiment without what breaks a limit: its name, the experiment (None if nothing is left), and what is not in
    it and why.
    """

    name: str
    experiment: Experiment | None
    left_out: tuple[str, ...]


def bound_experiments(
    station: Station, outcomes: Sequence[Outcome], robot: Sequence[RobotPlace] = ()
) -> list[BoundExperiment]:
    """Every experiment of a station within its limits, by what became of the motions; without limits, as it is.

    What its robot rules out is left out, too.

    A robot chooses the place, the worker the way. So a place stays only if no way that stays breaks a limit there, for
    any worker who reaches it, and not where all ways in which it could be used are gone. Of all sets of ways, that with
    the most places is kept, of these the largest.
    """
    out = ruled_out(robot)
    return [_bound(part, [each for each in outcomes if _is_of(part, each.doing)], out) for part in parts_of(station)]


def _bound(part: Part, outcomes: Sequence[Outcome], robot: Mapping[tuple[str, str], Phrase]) -> BoundExperiment:
    experiment = part.experiment
    out = {place: str(why) for (operation, place), why in robot.items() if operation == part.operation}
    own = {each.doing: each.breaches for each in outcomes if each.breaches}
    usable = {(each.doing.place, each.doing.way) for each in outcomes if each.usable}
    choices = _choices(part, own, usable, [place for place in experiment.actions if place not in out])
    ways, places = max(choices, key=lambda chosen: (len(chosen[1]), len(chosen[0])))
    lines = [
        *(
            f"action {place}: {out[place] if place in out else _why(part, own, place, ways)}"
            for place in experiment.actions
            if place not in places
        ),
        *(f"preference {way}: {_why_not(part, own, way, places)}" for way in part.station.ways if way not in ways),
    ]
    if not places:
        return BoundExperiment(experiment.name, None, (NOT_PRESENTED if out else ALL_LEFT_OUT, *lines))
    actions = {name: action for name, action in experiment.actions.items() if name in places}
    preferences = {name: each for name, each in experiment.preferences.items() if name in ways}
    kept = experiment.model_copy(update={"actions": actions, "preferences": preferences})
    return BoundExperiment(experiment.name, kept, tuple(lines))


def _is_of(part: Part, doing: Doing) -> bool:
    return doing.operation == part.operation and doing.worker in part.workers


def _choices(
    part: Part, own: Mapping[Doing, Sequence[Breach]], usable: Set[tuple[str, Way]], places: Sequence[str]
) -> Iterator[tuple[tuple[Way, ...], tuple[str, ...]]]:
    """Every set of ways, with those of the places that stay."""
    bad = {(doing.place, doing.way) for doing in own}
    limited = {place for place, _ in bad}
    for count in range(len(part.station.ways), 0, -1):
        for ways in itertools.combinations(part.station.ways, count):
            kept = (place for place in places if bad.isdisjoint((place, way) for way in ways))
            yield (
                ways,
                tuple(place for place in kept if place not in limited or any((place, way) in usable for way in ways)),
            )


def _why(part: Part, own: Mapping[Doing, Sequence[Breach]], place: str, ways: Sequence[Way]) -> str:
    here = [doing for doing in own if doing.place == place]
    first = next((doing for doing in here if doing.way in ways), here[0])
    return _said(part, first, own[first][0])


def _why_not(part: Part, own: Mapping[Doing, Sequence[Breach]], way: Way, places: Sequence[str]) -> str:
    here = [doing for doing in own if doing.way == way]
    first = next((doing for doing in here if doing.place in places), here[0])
    return _said(part, first, own[first][0])


def _said(part: Part, doing: Doing, breach: Breach) -> str:
    limit: Limit = part.station.limits[breach.limit]
    return (
        f"{doing.worker} at {doing.place}, {doing.way}: {limit.measure} above {limit.above_deg:g} degrees for "
        f"{breach.seconds:.1f} s in a cycle; limit {breach.limit + 1} allows {limit.at_most_s:g} s"
    )

"""What is said of an assessment in sentences, as keys of a catalogue with their values."""

from collections.abc import Iterator, Sequence

from fatigue_planner.ergonomics.result import Level, Phrase
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.station.assessment import BestPlaces, Outcome, PlaceForWorker, PlaceSummary, ReachShare, WholeCycle
from fatigue_planner.station.schema import Station

# Who cannot work where.
MISSED = "{worker} cannot reach {place}: the hand stays {away_cm:.0f} cm away"
MISSED_FAR = "{worker} cannot reach {place}"
TOO_WEAK = "{worker} is too weak for {place}: {joint} gives all it has"
IMPLAUSIBLE = "{worker} reaches {place} only as nobody would work: {finding}"
BROKEN = "{worker} breaks limit {limit} of the station at {place}: {seconds:.0f} s instead of at most {at_most_s:.0f}"
# What is not acceptable.
NOT_ACCEPTABLE = "{operation} at {place} is not acceptable for {seconds:.0f} of {cycle_s:.0f} s by {rule}"
NOT_ACCEPTABLE_AT_ALL = "{operation} at {place} is not acceptable by {rule}"
# What is best.
BEST = "Best for {operation}: {place}"
BEST_BY = "They tire at most {peak:.0%} of a joint's strength; the next best, {others}, cost {more:.0%} more fatigue"
BEST_ONLY = "They tire at most {peak:.0%} of a joint's strength; no others are allowed"
NONE_ALLOWED = "No place is recommended for {operation}: none is reached by all and acceptable"
INSTEAD = "{place} instead of {best} would tire {peak:.0%} of a joint's strength"
WORST_JOINT = "{worker}: the most tired joint is {joint}, which loses {peak:.0%} of its strength"
NO_JOINT = "{worker}: no joint tires"
SHORTFALL = "{worker} cannot go on for ever: in cycle {cycle} {joint} cannot give what is asked"
REACH = "{place} is reached by {share:.0%} of the {sex} population ({low:.0%} to {high:.0%} with 3 cm less or more)"
STRONG = "{share:.0%} of the {sex} population are strong enough for {place} ({joint} decides)"
# What has to be known.
ASSUMED_POPULATION = "Percentiles are of ANSUR II, soldiers of the US Army in 2012; give population for your own people"
OWN_POPULATION = "Percentiles are of the station's own population"
ASSUMED_MASS = "The mass of a percentile is the median of people as tall; strength is a percentile of its own"
ASSUMED_REACH = "People of one stature differ in reach by 3 cm (one standard deviation): a verdict within 3 cm can turn"
ASSUMED_SHOES = "Shoes raise the worker by {shoes_cm:.1f} cm"
ASSUMED_FEET = "Who works with the left hand stands so that places are mirrored"
ASSUMED_REST = "Each operation has {reach_s:g} s there and {return_s:g} s back; the rest of the {cycle_s:g} s is rest"
ASSUMED_LAW = (
    "Fatigue is the paper's law, which forgets within minutes: of breaks and rotation by the hour it says nothing"
)
ASSUMED_TOOL = "A tool is a point mass in the fist; vibration and its centre of mass are not simulated"
ASSUMED_SHIFT = "Length and breaks of the shift are not known"

Phrases = Iterator[Phrase]
Values = dict[str, str | float]


def headline_of(
    station: Station,
    places: Sequence[PlaceForWorker],
    summaries: Sequence[PlaceSummary],
    best: BestPlaces,
    cycles: Sequence[WholeCycle],
) -> tuple[Phrase, ...]:
    """The first lines: who cannot, what is not acceptable, what is best and by how much, the worst joint."""
    cannot = [why_not(station, each.outcome) for each in places if each.way is None]
    return (*cannot, *_not_acceptable(station, summaries), *_best(station, summaries, best), *_tired(cycles))


def why_not(station: Station, outcome: Outcome) -> Phrase:
    """Why a worker cannot work at a place, from the outcome that is nearest to it."""
    named: Values = {"worker": outcome.doing.worker, "place": outcome.doing.place}
    if outcome.breaches:
        breach = outcome.breaches[0]
        at_most = station.limits[breach.limit].at_most_s
        return Phrase(BROKEN, named | {"limit": breach.limit + 1, "seconds": breach.seconds, "at_most_s": at_most})
    if outcome.kind == "too_weak":
        return Phrase(TOO_WEAK, named | {"joint": outcome.joint or "the body"})
    if outcome.kind == "implausible":
        text = outcome.findings[0].text if outcome.findings else outcome.detail
        return Phrase(IMPLAUSIBLE, named | {"finding": text})
    if outcome.missed_m is None:
        return Phrase(MISSED_FAR, named)
    return Phrase(MISSED, named | {"away_cm": 100 * outcome.missed_m})


def _not_acceptable(station: Station, summaries: Sequence[PlaceSummary]) -> Phrases:
    for each in summaries:
        if each.level != Level.NOT_ACCEPTABLE:
            continue
        for rule in each.by:
            named: Values = {"operation": each.operation, "place": each.place, "rule": rule.title}
            if rule.not_acceptable_s:
                times = {"seconds": rule.not_acceptable_s, "cycle_s": station.cycle.duration_s}
                yield Phrase(NOT_ACCEPTABLE, named | times)
            else:
                yield Phrase(NOT_ACCEPTABLE_AT_ALL, named)


def _best(station: Station, summaries: Sequence[PlaceSummary], best: BestPlaces) -> Phrases:
    if not best.places:
        for operation in station.operations:
            if all((operation, place) in best.excluded for place in station.operations[operation].places):
                yield Phrase(NONE_ALLOWED, {"operation": operation})
        return
    for operation, place in best.places.items():
        yield Phrase(BEST, {"operation": operation, "place": place})
    assert best.peak is not None
    if best.next_places and best.next_above is not None:
        others = ", ".join(place for name, place in best.next_places.items() if place != best.places[name])
        yield Phrase(BEST_BY, {"peak": best.peak, "others": others, "more": best.next_above})
    else:
        yield Phrase(BEST_ONLY, {"peak": best.peak})
    for each in summaries:
        if each.place != best.places[each.operation] and each.peak is not None:
            values: Values = {"place": each.place, "best": best.places[each.operation], "peak": each.peak}
            yield Phrase(INSTEAD, values)


def _tired(cycles: Sequence[WholeCycle]) -> Phrases:
    for each in cycles:
        fatigue, named = each.fatigue, Values(worker=each.worker)
        if fatigue.entry:
            yield Phrase(WORST_JOINT, named | {"joint": joint_name(fatigue.entry), "peak": fatigue.peak})
        else:
            yield Phrase(NO_JOINT, named)
        if fatigue.shortfall_cycle is not None:
            short: Values = {"joint": joint_name(fatigue.shortfall_entry), "cycle": fatigue.shortfall_cycle}
            yield Phrase(SHORTFALL, named | short)


def of_population(shares: Sequence[ReachShare]) -> Phrases:
    """Who of the population reaches the places, and is strong enough."""
    for each in shares:
        yield Phrase(
            REACH,
            {"place": each.place, "sex": each.sex, "share": each.share, "low": each.share_low, "high": each.share_high},
        )
        if each.strong_share is not None:
            joint = joint_name(each.weakest_joint)
            yield Phrase(STRONG, {"share": each.strong_share, "sex": each.sex, "place": each.place, "joint": joint})


def assumptions_of(station: Station) -> tuple[Phrase, ...]:
    """What the results rest on."""
    cycle = station.cycle
    times = {"reach_s": cycle.reach_s, "return_s": cycle.return_s, "cycle_s": cycle.duration_s}
    found = [
        Phrase(ASSUMED_POPULATION if station.population is None else OWN_POPULATION),
        Phrase(ASSUMED_MASS),
        Phrase(ASSUMED_REACH),
        Phrase(ASSUMED_SHOES, {"shoes_cm": 100 * station.shoes_m}),
        Phrase(ASSUMED_REST, times),
        Phrase(ASSUMED_LAW),
    ]
    if station.feet == "free" and any(each.handedness == "left" for each in station.workers.values()):
        found.append(Phrase(ASSUMED_FEET))
    if station.tools:
        found.append(Phrase(ASSUMED_TOOL))
    if station.shift is None:
        found.append(Phrase(ASSUMED_SHIFT))
    return tuple(found)


def joint_name(entry: str) -> str:
    """An entry of the fatigue state in words: `right_shoulder_flexion:positive` is `right shoulder flexion`."""
    assert entry in ENTRIES
    return entry.partition(":")[0].replace("_", " ")

"""What is said of an assessment in sentences, as keys of a catalogue with their values."""

from collections.abc import Iterator, Mapping, Sequence

from fatigue_planner.ergonomics.result import Level, Phrase, ShownSeconds
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.robot.scan import Standpoint
from fatigue_planner.station.assessment import (
    BestPlaces,
    Change,
    Outcome,
    PlaceForWorker,
    PlaceSummary,
    ReachShare,
    RobotFinding,
    Rotation,
    Rule,
    Sensing,
    WholeCycle,
)
from fatigue_planner.station.robot_reach import ruled_out
from fatigue_planner.station.schema import Station

# Who cannot work where.
MISSED = "{worker} cannot reach {place}: the hand stays {away_cm:.0f} cm away"
MISSED_FAR = "{worker} cannot reach {place}"
TOO_WEAK = "{worker} is too weak for {place}: {joint} gives all it has"
IMPLAUSIBLE = "{worker} reaches {place} only as nobody would work: {finding}"
BROKEN = "{worker} breaks limit {limit} of the station at {place}: {seconds:.0f} s instead of at most {at_most_s:.0f}"
# What is not acceptable.
NOT_ACCEPTABLE = "{operation} at {place} is not acceptable for {seconds:.0f} of {cycle_s:.0f} s by {rules}"
NOT_ACCEPTABLE_AT_ALL = "{operation} at {place} is not acceptable by {rules}"
# What is best.
BEST = "Best for {operation}: {place}"
BEST_BY = (
    "A joint loses at most {peak:.0%} of its strength there; the next best, {others}, costs {more:.0%} more fatigue"
)
BEST_ONLY = "A joint loses at most {peak:.0%} of its strength there; no other place is allowed"
WARNED = "{operation} at {place}: not acceptable by {rules}, which only warns (binding)"
NONE_ALLOWED = "No place is recommended for {operation}: none is possible for all and acceptable"
NONE_PRESENTED = (
    "No place is recommended for {operation}: none is possible for all, acceptable, and presented by the robot"
)
COMPARED = "{operation} at {place}: a joint loses at most {peak:.0%} of its strength"
WORST_JOINT = "The most tired joint is {joint} of {worker}: it loses {peak:.0%} of its strength"
NO_JOINT = "No joint tires"
SHORTFALL = "{worker} cannot go on for ever: in cycle {cycle} {joint} cannot give what is asked"
REACH = "{place} is reached by {share:.0%} of the {sex} population ({low:.0%} to {high:.0%} with 3 cm less or more)"
REACH_NEARLY_ALL = "{place} is reached by nearly all of the {sex} population"
NOT_STRONG = "Nobody of the {sex} population is strong enough for {place}: even P99 of strength cannot bear the load"
STRONG = "{share:.0%} of the {sex} population are strong enough for {place} ({joint} decides)"
# What the robot can present.
ROBOT_ALL = "The {arm} reaches all {count} places from {here}"
ROBOT_ALL_THERE = "The {arm} reaches {reached} of {count} places from {here}, all from {there}"
ROBOT_MORE_THERE = "The {arm} reaches {reached} of {count} places from {here}, {more} from {there}"
ROBOT_NO_MORE = "The {arm} reaches {reached} of {count} places from {here}; no other height that was tried reaches more"
ROBOT_NEARER = "With its base {x_m:g} m ahead it reaches {more}, from {there}"
ROBOT_CLEARANCE = "It comes nearest to a worker at {place}: {distance_cm:.0f} cm to the {part} of {worker} ({way})"
ROBOT_MARGIN = "Its joints stay {margin:.0f} degrees or more from their limits"
# What has to be known.
ASSUMED_POPULATION = "Percentiles are of ANSUR II, soldiers of the US Army in 2012; give population for your own people"
OWN_POPULATION = "Percentiles are of the station's own population"
ASSUMED_MASS = "The mass of a percentile is the median of people as tall; strength is a percentile of its own"
ASSUMED_REACH = "People of one stature differ in reach by 3 cm (one standard deviation): a verdict within 3 cm can turn"
ASSUMED_SHOES = "Shoes raise the worker by {shoes_cm:.1f} cm"
ASSUMED_FEET = "The worker turns the feet to every place, so that it is straight ahead (feet: free)"
FIXED_FEET = "The feet point along x: who has to reach aside twists (feet: fixed)"
ASSUMED_REST = (
    "Each operation has {reach_s:g} s there and {return_s:g} s back; the rest of the {cycle_s:g} s loads no joint"
)
ASSUMED_LAW = (
    "Fatigue is the paper's law, which forgets within minutes: of breaks and rotation by the hour it says nothing"
)
ASSUMED_TOOL = "A tool is a point mass, in the fist or at its centre_of_mass_m; vibration is not simulated"
NOT_FOR_SAFETY = (
    "What is said of the robot is no risk assessment (ISO 10218): contact forces, speeds and its way from one place to "
    "the next are not computed, and clearance_m is no safety distance"
)
ASSUMED_SHIFT = "Length and breaks of the shift are not known"

# What single changes do, and another place in every cycle.
CHANGED = "{change}: {reached} of {of_places} places possible for all, {allowed} allowed"
CHANGED_BY = "{change}: {reached} of {of_places} places possible for all, {allowed} allowed, {saving:.0%} less fatigue"
CHANGED_MORE = "{change}: {reached} of {of_places} places possible for all, {allowed} allowed, {more:.0%} more fatigue"
CHANGED_NOTHING = "{change}: {reached} of {of_places} places possible for all, {allowed} allowed, as much fatigue"
UNTRIED = "What one change would do is not computed (--changes)"
ROTATION = "Another place in every cycle, {sequence}, saves {saving:.0%} of the cost of fatigue"
NO_ROTATION = "Another place in every cycle saves nothing"
SENSING = (
    "If a worker takes any way that may be used, a robot that sees which and plans by it saves {saving:.1%} "
    "({low:z.1%} to {high:z.1%}) of the cost of fatigue over the best schedule; no plan can save more than {most:.1%}"
)
SENSING_NOT_SHOWN = (
    "If a worker takes any way that may be used, a robot that sees which and plans by it saves nothing that can be "
    "shown over the best schedule: {low:z.1%} to {high:z.1%} of the cost of fatigue; no plan can save more than "
    "{most:.1%}"
)
SENSING_NOTHING = (
    "If a worker takes any way that may be used, a robot that sees which and plans by it always chooses as the best "
    "schedule does, so sensing saves nothing; no plan can save more than {most:.1%} of the cost of fatigue"
)
SENSING_CERTAIN = "Planning with sensing saves nothing: every worker has one way to work at each allowed place"
SENSING_NO_CHOICE = "Planning with sensing saves nothing: there is no choice between allowed places"

Phrases = Iterator[Phrase]
# Of a population, also with shorter arms.
NEARLY_ALL = 0.99
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
        named: Values = {"operation": each.operation, "place": each.place, "rules": rules_named(each.by)}
        if longest := max((rule.not_acceptable_s or 0.0 for rule in each.by), default=0.0):
            times = {"seconds": ShownSeconds(longest), "cycle_s": station.cycle.duration_s}
            yield Phrase(NOT_ACCEPTABLE, named | times)
        else:
            yield Phrase(NOT_ACCEPTABLE_AT_ALL, named)


def rules_named(rules: Sequence[Rule]) -> str:
    """The rules, that with the most seconds first: the part of the body that each finds worst, and its seconds."""
    ordered = sorted(rules, key=lambda rule: -(rule.not_acceptable_s or 0.0))
    times = [f"{ShownSeconds(rule.not_acceptable_s):.0f} s" if rule.not_acceptable_s else "" for rule in ordered]
    found = [", ".join(filter(None, parts)) for parts in zip((rule.part for rule in ordered), times, strict=True)]
    return ", ".join(
        f"{rule.title} ({said})" if said else rule.title for rule, said in zip(ordered, found, strict=True)
    )


def _best(station: Station, summaries: Sequence[PlaceSummary], best: BestPlaces) -> Phrases:
    if not best.places:
        for operation in station.operations:
            if all((operation, place) in best.excluded for place in station.operations[operation].places):
                yield Phrase(NONE_ALLOWED if station.robot is None else NONE_PRESENTED, {"operation": operation})
        if best.together is not None:
            yield best.together
        yield from _compared(summaries, {})
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
        if each.place == best.places[each.operation] and each.warned_by:
            values: Values = {"operation": each.operation, "place": each.place, "rules": rules_named(each.warned_by)}
            yield Phrase(WARNED, values)
    yield from _compared(summaries, best.places)


def _compared(summaries: Sequence[PlaceSummary], best: Mapping[str, str]) -> Phrases:
    """What the places that are not recommended do."""
    for each in summaries:
        if each.place != best.get(each.operation) and each.peak is not None:
            yield Phrase(COMPARED, {"operation": each.operation, "place": each.place, "peak": each.peak})


def _tired(cycles: Sequence[WholeCycle]) -> Phrases:
    if worst := max(cycles, key=lambda each: each.fatigue.peak, default=None):
        fatigue = worst.fatigue
        values: Values = {"worker": worst.worker, "peak": fatigue.peak}
        yield Phrase(WORST_JOINT, values | {"joint": joint_name(fatigue.entry)}) if fatigue.entry else Phrase(NO_JOINT)
    for each in cycles:
        if each.fatigue.shortfall_cycle is not None:
            short: Values = {"worker": each.worker, "cycle": each.fatigue.shortfall_cycle}
            yield Phrase(SHORTFALL, short | {"joint": joint_name(each.fatigue.shortfall_entry)})


def of_population(shares: Sequence[ReachShare]) -> Phrases:
    """Who of the population reaches the places, and is strong enough."""
    for each in shares:
        if each.share_low >= NEARLY_ALL:
            yield Phrase(REACH_NEARLY_ALL, {"place": each.place, "sex": each.sex})
        else:
            yield Phrase(
                REACH,
                {
                    "place": each.place,
                    "sex": each.sex,
                    "share": each.share,
                    "low": each.share_low,
                    "high": each.share_high,
                },
            )
        if each.strong_share is not None and not each.weakest_joint:
            yield Phrase(NOT_STRONG, {"sex": each.sex, "place": each.place})
        elif each.strong_share is not None:
            joint = joint_name(each.weakest_joint)
            yield Phrase(STRONG, {"share": each.strong_share, "sex": each.sex, "place": each.place, "joint": joint})


def of_changes(changes: Sequence[Change], best: BestPlaces) -> Phrases:
    """What single changes of the station would do; where nothing is recommended and none was tried, that."""
    if not changes and not best.places:
        yield Phrase(UNTRIED)
    for each in changes:
        values: Values = {"change": str(each.change), "reached": each.reached_by_all, "allowed": each.allowed}
        values |= {"of_places": each.of_places}
        template, fatigue = changed_fatigue(each)
        yield Phrase(template, values | fatigue)


def changed_fatigue(change: Change) -> tuple[str, Values]:
    """The sentence for what a change does to the mean cost of fatigue, and its value, as far as it is shown."""
    saving = change.saving_everywhere
    if saving is None:
        return CHANGED, {}
    if f"{saving:z.0%}" == "0%":
        return CHANGED_NOTHING, {}
    return (CHANGED_BY, {"saving": saving}) if saving > 0 else (CHANGED_MORE, {"more": -saving})


def of_robot(station: Station, robot: RobotFinding | None) -> Phrases:
    """How many places the robot reaches, from where it would reach more, how near it comes, and what is left out."""
    if robot is None or station.robot is None:
        return
    base, count = station.robot.base_m, len({each.place for each in robot.places})
    here = next(each for each in robot.scan if (each.x_m, each.height_m) == (base.x, base.z))
    above = [each for each in robot.scan if each.x_m == base.x]
    there = max(above, key=lambda each: (each.reached, -abs(each.height_m - base.z)))
    values: Values = {"arm": robot.arm, "reached": here.reached, "count": count, "here": _standing(here)}
    if here.reached == count:
        yield Phrase(ROBOT_ALL, values)
    elif there.reached == here.reached:
        yield Phrase(ROBOT_NO_MORE, values)
    else:
        template = ROBOT_ALL_THERE if there.reached == count else ROBOT_MORE_THERE
        yield Phrase(template, values | {"more": there.reached, "there": _standing(there)})
    best = max(robot.scan, key=lambda each: (each.reached, -abs(each.x_m - base.x), -abs(each.height_m - base.z)))
    if best.reached > there.reached:
        yield Phrase(ROBOT_NEARER, {"x_m": best.x_m, "more": best.reached, "there": _standing(best)})
    met = [(each.meeting, each) for each in robot.places if each.meeting is not None]
    if met:
        meeting, place = min(met, key=lambda pair: pair[0].distance_m)
        near: Values = {"distance_cm": 100 * meeting.distance_m, "part": meeting.part, "worker": meeting.worker}
        yield Phrase(ROBOT_CLEARANCE, near | {"place": place.place, "way": meeting.way})
    if margins := [each.joint_margin_deg for each in robot.places if not each.reason]:
        yield Phrase(ROBOT_MARGIN, {"margin": min(margins)})
    yield from ruled_out(robot.places).values()


def _standing(at: Standpoint) -> str:
    """What a base at this height stands on."""
    return f"a pedestal of {at.height_m:g} m" if at.height_m > 0 else "the floor"


def of_rotation(rotation: Rotation | None) -> Phrases:
    """What another place in every cycle does, where there is a choice."""
    if rotation is None:
        return
    if rotation.saving <= 0 or len(rotation.sequence) < 2:
        yield Phrase(NO_ROTATION)
    else:
        sequence = " - ".join("+".join(places.values()) for places in rotation.sequence)
        yield Phrase(ROTATION, {"sequence": sequence, "saving": rotation.saving})


def of_sensing(station: Station, best: BestPlaces, sensing: Sensing | None) -> Phrases:
    """What planning with sensing adds to the best schedule, where the station leaves a choice of places."""
    if sensing is None:
        if best.places and any(len(each.places) > 1 for each in station.operations.values()):
            yield Phrase(SENSING_NO_CHOICE)
        return
    values: Values = {"low": sensing.low, "high": sensing.high, "most": sensing.most}
    if sensing.certain:
        yield Phrase(SENSING_CERTAIN)
    elif sensing.low == sensing.high == 0:
        yield Phrase(SENSING_NOTHING, {"most": sensing.most})
    elif sensing.low <= 0:
        yield Phrase(SENSING_NOT_SHOWN, values)
    else:
        yield Phrase(SENSING, values | {"saving": sensing.saving})


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
        Phrase(ASSUMED_FEET if station.feet == "free" else FIXED_FEET),
        Phrase(ASSUMED_LAW),
    ]
    if station.tools:
        found.append(Phrase(ASSUMED_TOOL))
    if station.robot is not None:
        found.append(Phrase(NOT_FOR_SAFETY))
    if station.shift is None:
        found.append(Phrase(ASSUMED_SHIFT))
    return tuple(found)


def joint_name(entry: str) -> str:
    """An entry of the fatigue state in words: `right_shoulder_flexion:positive` is `right shoulder flexion`."""
    assert entry in ENTRIES
    return entry.partition(":")[0].replace("_", " ")

"""What is said of rotation at a line in sentences, as keys of a catalogue with their values."""

from collections.abc import Iterator

from fatigue_planner.ergonomics.result import Phrase
from fatigue_planner.station import statements
from fatigue_planner.station.line.rotate import CrewRotation

# Who cannot work where.
STATED_NOT = "as the file of the line says (not_at)"
NOT_ALLOWED = "{worker} at {station}: the work is not acceptable by {rules}, even at the best place"
UNMANNED = "The stations cannot be manned all the time by those who can work at them"
FOR_NOBODY = "Nobody of the crew can work at {station}"
# What the rotation gains.
LARGEST = "The largest load over acceptable load of a worker is {largest:.2f}, with {changes} changes of place"
NOT_PROVEN = "That is not proven to be the least: nothing is below {bound:.2f} and {changes} changes"
STAYING = "If everybody stays where that is best for the crew: {staying:.2f}"
NO_STAYING = "Not everybody can stay at one station"
USUAL = "If everybody goes on to the next station every hour: {usual:.2f}"
NO_USUAL = "Going on every hour sends somebody where he or she cannot or may not work"
NO_HELP = "Rotation does not help"
REDESIGN = "Rotation does not help; redesign {stations}"
EASED = "The load is more than is acceptable; without that of {station} it would be {eased:.2f}"
PAUSE = "Without the pause at {at_min:g} min, worked through: {more:+.0%}"
# What else the hours of a shift decide.
LIFTING = "{worker} lifts or lowers loads in {hours:.1f} h of the rota: duration {duration} of NIOSH's equation"
LIFTING_TOO_LONG = "{worker} lifts or lowers loads in {hours:.1f} h of the rota: more than NIOSH's equation is for"
REMEMBER = (
    "The measures of the rota remember the hours of a shift; the fatigue laws (Ma, 3CC-r) forget within minutes, so no "
    "hourly plan rests on them"
)
# What is balanced, by measure.
BALANCED = {
    "acceptable_effort": "effort over the maximum acceptable effort (Potvin 2012)",
    "dose": "damage over the cut point of DUET (Gallagher et al. 2018)",
    "cumulative_strain_index": "cumulative strain index of the hands over 10 (Garg et al. 2017)",
}
# What has to be known.
ASSUMED_SLOTS = "Slots are equally long in work; a break may fall into one, and counts as rest"
ASSUMED_DAY = (
    "The day of the maximum acceptable effort is 8 h: a shorter shift leaves the rest of it free. Loads are rounded up "
    "to whole percents of the strength"
)
ASSUMED_DOSE = "The curve of DUET is for hands; for joints it is used with their largest load as the rating"
ASSUMED_LOW = "What is not stated of hands counts at the low end of its range"
ASSUMED_FAIR = "Fairness is the least sum of the squares of what each bears most; no source says which measure is right"
ASSUMED_ORDER = "Persons are in the order of the file; what each bears is not shown"


def of_posts(found: CrewRotation) -> Iterator[Phrase]:
    """Where the best that a worker can do is forbidden by a rule."""
    for worker, own in found.posts.items():
        for station, post in own.items():
            if post.rules:
                yield Phrase(NOT_ALLOWED, {"worker": worker, "station": station, "rules": post.rules})


def of_gain(found: CrewRotation) -> Iterator[Phrase]:
    """What the best rota comes to, beside staying and going on every hour."""
    if found.advice is None:
        yield Phrase(UNMANNED)
        for station in found.line.stations:
            if all(own[station].demand is None for own in found.posts.values()):
                yield Phrase(FOR_NOBODY, {"station": station})
        return
    advice, best = found.advice, found.advice.best
    yield Phrase(LARGEST, {"largest": best.largest, "changes": best.changes})
    if not best.exact:
        yield Phrase(NOT_PROVEN, {"bound": best.burden_bound, "changes": best.changes_bound})
    yield Phrase(NO_STAYING) if advice.staying is None else Phrase(STAYING, {"staying": advice.staying})
    yield Phrase(NO_USUAL) if advice.usual is None else Phrase(USUAL, {"usual": advice.usual})


def of_redesign(found: CrewRotation) -> Iterator[Phrase]:
    """Whether rotation helps at all, and which station to redesign."""
    if found.advice is None:
        return
    advice, stations = found.advice, list(found.line.stations)
    at = [stations[number] for number in advice.too_much]
    if not advice.helps:
        at = at or ([stations[advice.redesign[0]]] if advice.redesign is not None else [])
        yield Phrase(REDESIGN, {"stations": ", ".join(at)}) if at else Phrase(NO_HELP)
    if advice.redesign is not None:
        yield Phrase(EASED, {"station": stations[advice.redesign[0]], "eased": advice.redesign[1]})


def of_shift(found: CrewRotation) -> Iterator[Phrase]:
    """What pauses are worth, and for how long who lifts."""
    for pause, more in zip(found.line.line.shift.breaks, found.pauses, strict=False):
        yield Phrase(PAUSE, {"at_min": pause.at_min, "more": more})
    for worker, lifting in found.lifting.items():
        who: dict[str, str | float] = {"worker": worker, "hours": lifting.hours}
        yield (
            Phrase(LIFTING_TOO_LONG, who)
            if lifting.duration is None
            else Phrase(LIFTING, who | {"duration": lifting.duration})
        )


def assumptions_of(found: CrewRotation) -> Iterator[Phrase]:
    """What the rota rests on."""
    yield Phrase(REMEMBER)
    yield Phrase(ASSUMED_SLOTS)
    yield Phrase({"acceptable_effort": ASSUMED_DAY, "dose": ASSUMED_DOSE}.get(found.line.line.measure, ASSUMED_LOW))
    yield Phrase(ASSUMED_FAIR)
    first = next(iter(found.line.stations.values()))
    own = statements.OWN_POPULATION
    yield Phrase(statements.ASSUMED_POPULATION if first.population is None else own)
    yield Phrase(statements.ASSUMED_MASS)
    yield Phrase(statements.ASSUMED_REACH)
    yield Phrase(ASSUMED_ORDER)

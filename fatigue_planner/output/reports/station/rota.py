"""The page of a line: a rota to hang up on one side, then who cannot work where and what loads whom how much."""

from collections.abc import Iterator, Sequence

from fatigue_planner import __version__
from fatigue_planner.core.files import digest_of
from fatigue_planner.ergonomics.result import Level, Phrase
from fatigue_planner.output.reports.page import Points, Table, Text
from fatigue_planner.output.reports.station.blocks import AnyBlock, Group, Groups, Part, table
from fatigue_planner.output.reports.station.catalogue import Catalogue
from fatigue_planner.output.reports.station.judgements import judgement_text
from fatigue_planner.output.reports.station.page import SHOWN_DIGITS, render
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.station.line import statements
from fatigue_planner.station.line.advice import ACCEPTABLE
from fatigue_planner.station.line.measures import MEASURES
from fatigue_planner.station.line.rotate import CrewRotation
from fatigue_planner.station.statements import joint_name

PAGE = "rota.html"
NOTHING = "–"
# So many sentences of a kind fit on the first side; so many regions are worth a line.
MOST, MOST_REGIONS = 4, 8


def rota_page(found: CrewRotation, texts: Catalogue) -> str:
    """The page in a language; workers are called by their pseudonyms, and nothing is said of what each bears."""
    line, wording = found.line.line, Wording(texts, (), found.line.line.crew)
    title = wording.say("Line {name}: who works where", name=wording.name(line.name))
    footer = wording.say(
        "Line file {digest}, fatplan {version}. All numbers are in {json}. Same files and version, same page.",
        digest=f"`{_digest(found)[:SHOWN_DIGITS]}`", version=__version__, json="`rotation.json`",
    )  # fmt: skip
    front = [
        *([Part(wording.say("Rota"), [_rota(found, wording)])] if found.advice is not None else []),
        Part(wording.say("In short"), [Groups(list(_groups(found, wording)))]),
        Part(wording.say("What this rests on"), [Points(_sentences(statements.assumptions_of(found), wording))]),
    ]
    sections = [
        Part(wording.say("Who cannot work where"), [_cannot(found, wording), *_forbidden(found, wording)]),
        Part(
            wording.say("Pauses and lifting"),
            [Points(_sentences(statements.of_shift(found), wording)), *_lifted(found, wording)],
        ),
        Part(wording.say("Loads of the shift"), [_loads(found, wording)]),
        Part(wording.say("Within a cycle"), [_within(found, wording), Text(wording.sentence(Phrase(FORGETS)))]),
    ]
    return render(wording, title, footer, _verdict(found, wording), front, sections, _facts(found, wording))


FORGETS = (
    "That is the course of minutes, by the law of Ma, which forgets it as fast: it says nothing of the hours of a "
    "shift, and is no part of the rota"
)


def _digest(found: CrewRotation) -> str:
    """Of what the files of the line and its stations say."""
    return digest_of([found.line.line.plain(), {name: each.plain() for name, each in found.line.stations.items()}])


def _facts(found: CrewRotation, wording: Wording) -> list[tuple[str, str]]:
    line = found.line.line
    breaks = ", ".join(
        wording.say("at {begin} for {minutes:g} min", begin=_clock(each.at_min), minutes=each.minutes)
        for each in line.shift.breaks
    )
    return [
        (wording.say("Shift"), wording.say("{hours:g} h", hours=line.shift.hours)),
        (wording.say("Breaks"), breaks or NOTHING),
        (wording.say("Work in a slot"), wording.say("{minutes:.0f} min", minutes=line.slot_s / 60)),
        (wording.say("Date"), ""),
    ]


def _verdict(found: CrewRotation, wording: Wording) -> tuple[str, str]:
    if found.advice is None:
        return wording.light(Level.NOT_ACCEPTABLE), wording.sentence(Phrase(statements.UNMANNED))
    largest = found.advice.best.largest
    forbidden = any(found.posts[worker][station].rules for worker, station in _posts(found))
    level = Level.NOT_ACCEPTABLE if forbidden or largest > ACCEPTABLE else Level.ACCEPTABLE
    changes = found.advice.best.changes
    text = "Load over acceptable load, for the worst of all workers: {largest:.2f}, with {changes} changes of place."
    said = wording.say(text, largest=largest, changes=changes)
    if forbidden:
        said += " " + wording.say("A rule forbids what somebody does in it: see below.")
    return wording.light(level), said


def _posts(found: CrewRotation) -> Iterator[tuple[str, str]]:
    """Who works where in the rota."""
    for number, worker in enumerate(found.line.line.crew):
        places = (found.place(number, slot) for slot in range(found.line.line.slots))
        yield from ((worker, station) for station in dict.fromkeys(places) if station)


def _rota(found: CrewRotation, wording: Wording) -> Table:
    line = found.line.line
    times = [f"{_clock(spans[0][0])}–{_clock(spans[-1][1])}" for spans in line.slot_times()]
    rows = [
        [
            wording.worker(worker),
            *(
                wording.name(place) if place else wording.say("free")
                for place in (found.place(number, slot) for slot in range(line.slots))
            ),
        ]
        for number, worker in enumerate(line.crew)
    ]
    caption = wording.say("Hours and minutes from the beginning of the shift; a break may fall into a slot.")
    return Table(caption, [wording.say("Worker"), *times], rows)


def _clock(minutes: float) -> str:
    hours, rest = divmod(round(minutes), 60)
    return f"{hours}:{rest:02d}"


def _groups(found: CrewRotation, wording: Wording) -> Iterator[Group]:
    gain = _sentences([*statements.of_redesign(found), *statements.of_gain(found)], wording)
    yield Group(wording.say("What the rotation gains"), gain)
    for title, phrases in (
        (wording.say("Not acceptable by a rule"), list(statements.of_posts(found))),
        (wording.say("Pauses and lifting"), list(statements.of_shift(found))),
    ):
        if phrases:
            yield Group(title, _capped(_sentences(phrases, wording), wording))
    cannot = [
        wording.say("{worker}: not at {stations}", worker=wording.worker(worker), stations=wording.names(where)) + "."
        for worker, where in found.cannot.items()
        if where
    ]
    cannot = cannot or [wording.say("Everybody can work everywhere.")]
    yield Group(wording.say("Who cannot work where"), _capped(cannot, wording))


def _capped(items: list[str], wording: Wording) -> list[str]:
    """As many sentences as the first side has room for, and how many more there are."""
    more = len(items) - MOST
    return items if more <= 0 else [*items[:MOST], wording.say("{more} more: see the details.", more=more)]


def _sentences(phrases: Iterator[Phrase] | Sequence[Phrase], wording: Wording) -> list[str]:
    return [wording.sentence(each) for each in phrases]


def _cannot(found: CrewRotation, wording: Wording) -> AnyBlock:
    rows = [
        [
            wording.worker(worker),
            wording.name(station),
            " ".join(_sentences(found.posts[worker][station].why_not, wording))
            or wording.sentence(Phrase(statements.STATED_NOT)),
        ]
        for worker, where in found.cannot.items()
        for station in where
    ]
    if not rows:
        return Text(wording.say("Everybody can work everywhere."))
    return table(wording, "Who does not work at a station, and why.", ["Worker", "Station", "Why not"], rows)


def _forbidden(found: CrewRotation, wording: Wording) -> Iterator[AnyBlock]:
    if sentences := _sentences(statements.of_posts(found), wording):
        yield Text(wording.say("Who can, but not acceptably by a rule:"))
        yield Points(sentences)


def _loads(found: CrewRotation, wording: Wording) -> AnyBlock:
    """Of the whole crew, by region, the most that any worker bears of each measure."""
    if found.advice is None:
        return Text(wording.sentence(Phrase(statements.UNMANNED)))
    by_measure = {
        kind: {
            region: max(own[kind][region] for own in found.ratios.values() if own)
            for region in next(own for own in found.ratios.values() if own)[kind]
        }
        for kind in MEASURES
    }
    regions = dict.fromkeys(region for own in by_measure.values() for region in own)
    order = sorted(regions, key=lambda region: -by_measure[found.line.line.measure].get(region, -1.0))
    shown = [region for region in order if any(own.get(region, 0) > 0 for own in by_measure.values())][:MOST_REGIONS]
    rows = [
        [
            wording.catalogue.term(region.replace("_", " ")),
            *(wording.number(own[region], 2) if region in own else NOTHING for own in by_measure.values()),
        ]
        for region in shown
    ]
    caption = wording.say(
        "Load over acceptable load in the rota by three measures, each for the worst of all workers: 1 is acceptable. "
        "Balanced is: {measure}.",
        measure=wording.say(statements.BALANCED[found.line.line.measure]),
    )
    header = ["Region", "Maximum acceptable effort", "Dose of damage", "Cumulative strain index"]
    return Table(caption, [wording.say(name) for name in header], rows)


def _lifted(found: CrewRotation, wording: Wording) -> Iterator[Table]:
    """By station the lifting index with the hours of the rota, if loads are lifted."""
    rows = [[wording.name(station), judgement_text(each, wording)] for station, each in found.lifted.items()]
    if rows:
        caption = (
            "NIOSH's lifting index with the hours of lifting in the rota, for the worst of all workers; each station "
            "alone, also where somebody lifts at several."
        )
        yield table(wording, caption, ["Station", "NIOSH lifting index"], rows)


def _within(found: CrewRotation, wording: Wording) -> Table:
    """By station, how tired the most tired joint is in the cycle that repeats for ever, of those who can work there."""
    rows = []
    for station in found.line.stations:
        own = [each[station].fatigue for each in found.posts.values()]
        worst = max((each for each in own if each is not None), key=lambda each: each.peak, default=None)
        joint = wording.catalogue.term(joint_name(worst.entry)) if worst is not None and worst.entry else NOTHING
        short = worst is not None and any(each is not None and each.shortfall_cycle is not None for each in own)
        rows.append([
            wording.name(station),
            wording.say("{cycle_s:.1f} s", cycle_s=found.line.cycle_s(station)),
            joint,
            NOTHING if worst is None else wording.percent(worst.peak),
            wording.say("no: a joint cannot give what is asked" if short else "yes"),
        ])  # fmt: skip
    caption = "The most tired joint when the cycle of a station is repeated without end, for the worst of all workers."
    header = ["Station", "Cycle", "Joint", "Strength lost", "Can go on"]
    return table(wording, caption, header, rows)

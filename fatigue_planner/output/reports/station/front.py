"""The first side of a station's page: who cannot, what is not acceptable, what to do, and what that rests on."""

from collections.abc import Iterator, Mapping

from fatigue_planner.ergonomics.result import Level, Phrase, ShownSeconds
from fatigue_planner.output.reports.page import Points, Table, Text
from fatigue_planner.output.reports.station.blocks import AnyBlock, Group, Groups, Part, PostureRow
from fatigue_planner.output.reports.station.pictures import Posture, figure_of
from fatigue_planner.output.reports.station.sheet import SHEET_PX, printed_px
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.station import statements
from fatigue_planner.station.assessment import Change, Doing, Judged, PlaceSummary, StationAssessment

CANNOT = (
    statements.MISSED, statements.MISSED_FAR, statements.TOO_WEAK, statements.IMPLAUSIBLE, statements.BROKEN,
)  # fmt: skip
FORBIDDEN = (statements.NOT_ACCEPTABLE, statements.NOT_ACCEPTABLE_AT_ALL)
TIRED = (statements.WORST_JOINT, statements.NO_JOINT, statements.SHORTFALL)
MOST_CHANGES, MOST_PLACES, MOST_RULES = 3, 6, 2
# So many sentences of a kind, and places, at most: the first that fit on the first side. The details have all.
FITTING = ((6, MOST_PLACES), (5, MOST_PLACES), (4, MOST_PLACES), (4, 4), (3, 4), (3, 3), (2, 3), (2, 2))


def shown(assessment: StationAssessment) -> list[tuple[str, Doing]]:
    """The motions that the first side shows, with what they are: of every operation the worst place, and the best.

    Each is shown for the worker for whom it is worst. Without an allowed place the least bad that most reach is shown;
    the other places, too, while there are few.
    """
    judged = {each.doing: each for each in assessment.judged}
    found = []
    few = len(assessment.summaries) <= MOST_PLACES
    for operation in assessment.station.operations:
        worst_of: dict[str, Doing] = {}
        for each in assessment.places:
            doing = each.outcome.doing
            known = worst_of.get(each.place)
            is_here = each.operation == operation and each.way is not None
            if is_here and (known is None or _badness(judged[doing]) > _badness(judged[known])):
                worst_of[each.place] = doing
        if not worst_of:
            continue
        missed = {each.place: len(each.missed_by) for each in assessment.summaries if each.operation == operation}
        order = sorted(worst_of, key=lambda place: _badness(judged[worst_of[place]]), reverse=True)
        best = assessment.best.places.get(operation)
        last = best or min(reversed(order), key=missed.__getitem__)
        middle = [place for place in order if place not in {order[0], last}] if few else []
        if order[0] != last:
            found += [("worst", worst_of[order[0]]), *(("", worst_of[place]) for place in middle)]
        found.append(("best" if best else "least bad", worst_of[last]))
    return found


def _badness(judged: Judged) -> tuple[Level, float, float]:
    seconds = max((rule.not_acceptable_s or 0.0 for rule in judged.by), default=0.0)
    return judged.level, seconds, judged.fatigue.peak


def facts(assessment: StationAssessment, wording: Wording) -> list[tuple[str, str]]:
    """What the page is about; what is empty is to be filled in by hand."""
    about = assessment.station.about
    named = [
        ("Company", about.company), ("Plant", about.plant), ("Revision", about.revision),
        ("Assessor", about.assessor), ("Date", about.date),
    ]  # fmt: skip
    cycle = wording.say("{cycle_s:g} s", cycle_s=assessment.station.cycle.duration_s)
    return [*((wording.say(label), value) for label, value in named), (wording.say("Cycle"), cycle)]


def verdict(assessment: StationAssessment, wording: Wording) -> tuple[str, str]:
    """What comes first: the level of the recommended cycle, or that there is none."""
    if not assessment.best.places:
        return wording.light(Level.NOT_ACCEPTABLE), wording.say("No cycle is recommended.")
    level = max((each.level for each in assessment.cycles), default=Level.ACCEPTABLE)
    places = ", ".join(
        f"{wording.name(operation)} – {wording.name(place)}" for operation, place in assessment.best.places.items()
    )
    return wording.light(level), wording.say(
        "The recommended cycle ({places}), for the worst of all workers.", places=places
    )


def front(assessment: StationAssessment, postures: Mapping[Doing, Posture], wording: Wording) -> list[Part]:
    """The parts of the first side, with as many sentences and places as one sheet of paper has room for."""
    figures = [
        figure_of(postures[doing], wording, _shown_as(doing.operation, what, wording))
        for what, doing in shown(assessment)
    ]
    pictures: AnyBlock = (
        PostureRow(figures) if figures else Text(wording.say("Nothing is shown: nobody reaches any place."))
    )
    rest = Points(list(_rests_on(assessment, wording)))
    parts: list[Part] = []
    for most, most_places in FITTING:
        parts = [
            Part(wording.say("In short"), [Groups(_groups(assessment, wording, most))]),
            Part(wording.say("Places"), [places(assessment, wording, most_places)]),
            Part(wording.say("Postures"), [pictures]),
            Part(wording.say("What this rests on"), [rest]),
        ]
        if printed_px(" ".join(verdict(assessment, wording)), parts) < SHEET_PX:
            break
    return parts


def _shown_as(operation: str, what: str, wording: Wording) -> str:
    return f"{wording.name(operation)}, {wording.say(what)}" if what else wording.name(operation)


def _groups(assessment: StationAssessment, wording: Wording, most: int) -> list[Group]:
    headline = assessment.headline
    cannot = [wording.sentence(each) for each in headline if each.template in CANNOT]
    forbidden = [wording.sentence(each) for each in headline if each.template in FORBIDDEN]
    tired = [wording.sentence(each) for each in headline if each.template in TIRED]
    others = [each for each in headline if each.template not in {*CANNOT, *FORBIDDEN, *TIRED}]
    compared = [wording.sentence(each) for each in others if each.template == statements.COMPARED]
    advice = [wording.sentence(each) for each in others if each.template != statements.COMPARED]
    todo = [*advice, *_changes(assessment, wording), *compared]
    groups = [
        (wording.say("Who cannot"), cannot or [wording.say("Every worker reaches every place.")]),
        (wording.say("Not acceptable"), forbidden or [wording.say("No rule finds a place not acceptable.")]),
        (wording.say("What to do"), todo),
        (wording.say("Worst joint and score"), [*tired, *_worst_score(assessment, wording)]),
    ]
    if robot := list(map(wording.sentence, statements.of_robot(assessment.station, assessment.robot))):
        groups.append((wording.say("Robot"), robot))
    return [Group(title, _at_most(items, most, wording)) for title, items in groups]


def _at_most(items: list[str], most: int, wording: Wording) -> list[str]:
    more = len(items) - most
    return items if more <= 0 else [*items[:most], wording.say("{more} more: see the details.", more=more)]


def _changes(assessment: StationAssessment, wording: Wording) -> Iterator[str]:
    """The changes that help most, and what planning does."""
    yield from (f"{changed(each, wording)}." for each in assessment.changes[:MOST_CHANGES])
    if not assessment.changes:
        yield from map(wording.sentence, statements.of_changes((), assessment.best))
    yield from map(wording.sentence, planning(assessment))


def planning(assessment: StationAssessment) -> Iterator[Phrase]:
    """What another place in every cycle does, and what planning with sensing adds to it."""
    yield from statements.of_rotation(assessment.rotation)
    yield from statements.of_sensing(assessment.station, assessment.best, assessment.sensing)


def changed(change: Change, wording: Wording) -> str:
    """What one change would do."""
    what = wording.sentence(change.change)[:-1]
    values = {"reached": change.reached_by_all, "allowed": change.allowed, "of_places": change.of_places}
    template, fatigue = statements.changed_fatigue(change)
    return wording.say(template, change=what, **values, **fatigue)


def _worst_score(assessment: StationAssessment, wording: Wording) -> Iterator[str]:
    """The rule with the most seconds at the worst place, and the part it is worst at, for how long of the cycle."""
    judged = {each.doing: each for each in assessment.judged}
    doings = [each.outcome.doing for each in assessment.places if each.way is not None]
    worst = max((judged[doing] for doing in doings), key=_badness, default=None)
    if worst is None or not worst.by:
        return
    rule = max(worst.by, key=lambda each: each.not_acceptable_s or 0.0)
    found = worst.judgements[rule.kind]
    where = {"place": wording.name(worst.doing.place), "worker": wording.worker(worst.doing.worker)}
    score = {"rule": wording.catalogue.term(rule.title), "value": wording.value(found)}
    words = wording.catalogue.term(found.words[0]) if found.words else ""
    yield wording.say("Worst score: {rule} {value} at {place}, {worker}: {words}.", **where, **score, words=words)
    text = "Worst there: {part}, for {seconds:.0f} of {cycle_s:.0f} s not acceptable."
    part, cycle_s = wording.part(found), assessment.station.cycle.duration_s
    if rule.not_acceptable_s and part:
        yield wording.say(text, part=part, seconds=ShownSeconds(rule.not_acceptable_s), cycle_s=cycle_s)
    edition, origin = wording.catalogue.term(found.edition), wording.catalogue.term(found.origin.words)
    yield wording.say("Edition: {edition} ({origin}).", edition=edition, origin=origin)


def places(assessment: StationAssessment, wording: Wording, most: int | None = None) -> Table:
    """All places; or in brief so many at most: the recommended first, then the worst."""
    header = ["Operation", "Place", "Result", "Cannot", "Decided by", "Highest fatigue"]
    best, chosen = assessment.best.places, assessment.summaries
    brief = most is not None
    if brief:
        chosen = tuple(sorted(chosen, key=lambda each: _place_order(each, best))[:most])
    else:
        header.append("Only warned by")
    rows = [_place(assessment, each, wording, brief) for each in assessment.summaries if each in chosen]
    left_out = len(assessment.summaries) - len(rows)
    caption = wording.say(
        "Every place, for the worst of the workers who reach it, each in the way that is best there. The fatigue is "
        "the share of its strength that a joint loses in the settled cycle."
    )
    if left_out:
        caption += " " + wording.say("{more} more: see the details.", more=left_out)
    return Table(caption, [wording.say(name) for name in header], rows)


def _place_order(each: PlaceSummary, best: Mapping[str, str]) -> tuple[bool, int, int]:
    return best.get(each.operation) != each.place, -len(each.missed_by), -int(each.level or 0)


def _place(assessment: StationAssessment, each: PlaceSummary, wording: Wording, brief: bool) -> list[str]:
    fatigue, cycle_s = "–", assessment.station.cycle.duration_s
    if each.peak is not None:
        joint = wording.catalogue.term(statements.joint_name(each.entry)) if each.entry else ""
        fatigue = f"{joint} {wording.percent(each.peak)}".strip()
    recommended = assessment.best.places.get(each.operation) == each.place
    place = wording.name(each.place)
    row = [
        wording.name(each.operation),
        wording.say("{place} (recommended)", place=place) if recommended else place,
        wording.light(each.level, wording.say("left out for all")),
        wording.workers(each.missed_by) or "–",
        wording.rules(each.by, cycle_s, MOST_RULES if brief else None) or "–",
        fatigue,
    ]
    return row if brief else [*row, wording.rules(each.warned_by, cycle_s) or "–"]


def _rests_on(assessment: StationAssessment, wording: Wording) -> Iterator[str]:
    """Inputs that are not stated and make ranges, then the assumptions."""
    yield from undecided(assessment, wording)
    yield from map(wording.sentence, assessment.assumptions)


def undecided(assessment: StationAssessment, wording: Wording) -> Iterator[str]:
    """Every input that is not stated, with the most that it alone would make of each value, in any of the cycles."""
    found: dict[str, dict[str, tuple[float, str]]] = {}
    for judgements in (each.judgements for each in (assessment.cycles or assessment.judged)):
        for judgement in judgements.values():
            if judgement.value is None:
                continue
            title, low = wording.catalogue.term(judgement.title), wording.number(judgement.value.low, judgement.digits)
            for decides in judgement.decides:
                high = wording.number(decides.value, judgement.digits)
                what = f"{title} {low} → {high} {wording.phrase(decides.condition)}"
                known = found.setdefault(decides.key, {}).get(judgement.indicator)
                if known is None or decides.value > known[0]:
                    found[decides.key][judgement.indicator] = decides.value, what
    for key, values in found.items():
        texts = "; ".join(text for _, text in values.values())
        yield wording.say("`{key}` is not stated: {values}.", key=key, values=texts)

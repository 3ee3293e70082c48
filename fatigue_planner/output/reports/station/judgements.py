"""The tables of indicators of a station's page: the whole cycle, every place, and the methods with their sources."""

from collections.abc import Collection, Iterator, Sequence
from itertools import groupby

from fatigue_planner.ergonomics.result import Assessment as Judgement
from fatigue_planner.ergonomics.result import ShownSeconds
from fatigue_planner.output.reports.page import Table, Text
from fatigue_planner.output.reports.station.blocks import AnyBlock, table
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.station import statements
from fatigue_planner.station.assessment import StationAssessment
from fatigue_planner.station.tables import INDICATORS

# A page with more cells of indicators is too heavy; the file beside it has all of them.
MAX_CELLS = 6000


def cycles(assessment: StationAssessment, wording: Wording) -> Iterator[AnyBlock]:
    """The whole cycle of every worker: its level and fatigue, and what every indicator finds."""
    term = wording.catalogue.term
    if assessment.best.together is not None:
        yield Text(wording.sentence(assessment.best.together))
    if not assessment.cycles:
        yield Text(wording.say("No worker can do all operations."))
        return
    rows = []
    for each in assessment.cycles:
        places = ", ".join(f"{wording.name(doing.place)} ({term(doing.way)})" for doing in each.doings)
        fatigue = each.fatigue
        joint = term(statements.joint_name(fatigue.entry)) if fatigue.entry else "–"
        short = "–" if fatigue.shortfall_cycle is None else wording.say(
            "from cycle {cycle}: {joint}", cycle=fatigue.shortfall_cycle,
            joint=term(statements.joint_name(fatigue.shortfall_entry)),
        )  # fmt: skip
        level = wording.light(each.level)
        rows.append([wording.worker(each.worker), places, level, wording.percent(fatigue.peak), joint, short])
    recommended = any(each.recommended for each in assessment.cycles)
    caption = (
        "The recommended cycle of every worker, repeated until fatigue no longer grows."
        if recommended
        else "No place is recommended: the least bad cycle of every worker, repeated until fatigue no longer grows."
    )
    header = ["Worker", "Places (way)", "Result", "Fatigue of the settled cycle", "Joint", "Cannot go on"]
    yield table(wording, caption, header, rows)
    labels = [wording.worker(each.worker) for each in assessment.cycles]
    caption = wording.say("What every indicator finds in the whole cycle.")
    yield _judged(wording, caption, labels, [each.judgements.values() for each in assessment.cycles])


def _judged(wording: Wording, caption: str, columns: Sequence[str], found: Sequence[Collection[Judgement]]) -> Table:
    """A row per indicator, a column per worker."""
    rows = [
        [wording.catalogue.term(row[0].title), *(judgement_text(each, wording) for each in row)]
        for row in zip(*found, strict=True)
    ]
    return Table(caption, [wording.say("Indicator"), *columns], rows)


def judgement_text(judgement: Judgement, wording: Wording) -> str:
    """A judgement in a cell of a table: its level, its value, how long and where it is worst."""
    text = wording.value(judgement)
    if judgement.levels is None:
        return wording.light(None, text)
    times, part = judgement.times, wording.part(judgement)
    seconds = ""
    if times and times.not_acceptable_s > 0:
        seconds = wording.say(", {seconds:.0f} s not acceptable", seconds=ShownSeconds(times.not_acceptable_s))
    where = ""
    if part and judgement.worst:
        where = wording.say("; worst: {part} at {time:.0f} s", part=part, time=judgement.worst.time_s)
    return f"{wording.levels(*judgement.levels)}: {text}{seconds}{where}"


def by_place(assessment: StationAssessment, wording: Wording) -> Iterator[AnyBlock]:
    """A table of indicators for every place, each worker in the best way."""
    judged = {each.doing: each for each in assessment.judged}
    usable = [each for each in assessment.places if each.way is not None]
    cells = 0
    for (operation, place), here in groupby(
        sorted(usable, key=lambda each: _order(assessment, each.operation, each.place)),
        lambda e: (e.operation, e.place),
    ):
        group = list(here)
        found = [judged[each.outcome.doing].judgements.values() for each in group]
        cells += len(found) * len(found[0])
        if cells > MAX_CELLS:
            yield Text(wording.say("The other places are in {file}.", file=f"`{INDICATORS}`"))
            return
        labels = [f"{wording.worker(each.worker)} ({wording.catalogue.term(str(each.way))})" for each in group]
        caption = wording.say(
            "{operation} at {place}, each worker in the best way.",
            operation=wording.name(operation), place=wording.name(place),
        )  # fmt: skip
        yield _judged(wording, caption, labels, found)
    yield Text(wording.say("All ways are in {file}.", file=f"`{INDICATORS}`"))


def _order(assessment: StationAssessment, operation: str, place: str) -> tuple[int, int]:
    operations = list(assessment.station.operations)
    return operations.index(operation), assessment.station.operations[operation].places.index(place)


def methods(assessment: StationAssessment, wording: Wording) -> Table:
    """Every method: edition, how far its rules were checked, and what has to be known."""
    term = wording.catalogue.term
    found: dict[str, Judgement] = {}
    all_judgements = [*(c.judgements for c in assessment.cycles), *(j.judgements for j in assessment.judged)]
    for judgements in all_judgements:
        for kind, each in judgements.items():
            if kind not in found or not found[kind].applies:
                found[kind] = each
    rows = [
        [
            term(each.title),
            term(each.edition),
            term(each.origin.words),
            " ".join(map(wording.sentence, each.remarks)) or "–",
        ]
        for each in found.values()
    ]
    header = ["Method", "Edition and variant", "Its rules were", "To be known"]
    return table(wording, "A rule that was not read in its source says so.", header, rows)

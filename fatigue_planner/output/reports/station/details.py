"""What follows the first side of a station's page: tables of everything, sources, limits, and a form to fill in."""

from collections.abc import Iterator, Mapping

from fatigue_planner.core.text import format_label
from fatigue_planner.ergonomics.result import ShownSeconds
from fatigue_planner.output.reports.page import Points, Table, Text
from fatigue_planner.output.reports.station import filled_in, front, judgements
from fatigue_planner.output.reports.station.blocks import AnyBlock, Part, PostureRow, table
from fatigue_planner.output.reports.station.maps import maps
from fatigue_planner.output.reports.station.pictures import Posture, figure_of
from fatigue_planner.output.reports.station.robot import robot_blocks
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.station import statements
from fatigue_planner.station.assessment import Doing, Outcome, StationAssessment
from fatigue_planner.station.tables import OUTCOMES


def details(assessment: StationAssessment, postures: Mapping[Doing, Posture], wording: Wording) -> Iterator[Part]:
    """The parts in their order; parts that have nothing to say are left out."""
    say = wording.say
    yield Part(say("Workers"), [_workers(assessment, wording)])
    yield Part(say("Operations and places"), list(_station(assessment, wording)))
    yield Part(say("All places"), [*maps(assessment, wording), front.places(assessment, wording)])
    yield Part(say("Who can do what"), [_outcomes(assessment, wording), *_left_out(assessment, wording)])
    yield Part(say("The cycle as a whole"), list(judgements.cycles(assessment, wording)))
    yield Part(say("Indicators by place"), list(judgements.by_place(assessment, wording)))
    yield Part(say("Methods and how far they were checked"), [judgements.methods(assessment, wording)])
    yield Part(say("Who of the population can"), [_population(assessment, wording)])
    if assessment.robot is not None:
        yield Part(say("The robot"), list(robot_blocks(assessment, assessment.robot, wording)))
    if changes := list(_changes(assessment, wording)):
        yield Part(say("Changes and rotation"), changes)
    if postures:
        yield Part(say("All postures"), list(_pictures(assessment, postures, wording)))
    yield Part(say("What is not computed, and why"), list(filled_in.not_computed(assessment, postures, wording)))
    yield Part(say("Risk assessment: to be filled in"), list(filled_in.form(wording)))
    yield Part(say("Signatures"), [filled_in.signatures(wording)])


def _workers(assessment: StationAssessment, wording: Wording) -> Table:
    term = wording.catalogue.term
    rows = [
        [
            wording.worker(each.name),
            term(each.sex),
            wording.number(100 * each.stature_m),
            wording.number(each.mass_kg),
            f"P{wording.number(each.stature_percentile)}",
            f"P{wording.number(each.strength_percentile)}",
            term(each.handedness),
            term("measured" if each.measured else "percentile"),
        ]
        for each in assessment.workers
    ]
    header = ["Worker", "Sex", "Stature, cm", "Mass, kg", "Percentile of stature", "Percentile of strength",
              "Better hand", "Stature from"]  # fmt: skip
    caption = "The workers are models, not persons: P5 is a stature that 5 % of the population do not exceed."
    return table(wording, caption, header, rows)


def _station(assessment: StationAssessment, wording: Wording) -> Iterator[AnyBlock]:
    station, term = assessment.station, wording.catalogue.term
    rows = []
    for name, each in station.operations.items():
        tools = dict.fromkeys(station.tool_at(name, place) for place in each.places)
        masses = [
            wording.say("{tool} ({mass:g} kg)", tool=wording.name(tool), mass=station.tools[tool].mass_kg)
            for tool in tools
            if tool is not None
        ]
        stated = {
            key: value for key, value in each.plain().items() if value is not None and key in each.model_fields_set
        }
        own = ("places", "seconds", "hand", "tool", "grip_width_m", "times_per_cycle")
        inputs = ", ".join(
            f"`{key}: {str(value).lower() if isinstance(value, bool) else value}`"
            for key, value in stated.items()
            if key not in own
        )
        rows.append([
            wording.name(name),
            wording.names(each.places),
            wording.number(each.seconds, 1),
            wording.number(each.times_per_cycle),
            term(each.hand),
            ", ".join(masses) or "–",
            inputs or "–",
        ])  # fmt: skip
    header = ["Operation", "Places", "Seconds", "Times a cycle", "Hand", "Tool", "Stated inputs"]
    yield table(wording, "The operations: all of them are done in every cycle.", header, rows)
    header = ["Place", "Ahead, cm", "To the left, cm", "Height, cm"]
    used = dict.fromkeys(place for each in station.operations.values() for place in each.places)
    at = {name: station.places[name] for name in used}
    places = [[wording.name(name), *(wording.number(100 * v) for v in (p.x, p.y, p.z))] for name, p in at.items()]
    yield table(wording, "The places of the hand, from the ground between the feet.", header, places)
    if station.limits:
        limits = [
            [
                str(i),
                term(each.measure.replace("_", " ")),
                wording.number(each.above_deg),
                wording.number(each.at_most_s),
            ]
            for i, each in enumerate(station.limits, start=1)
        ]
        header = ["Limit", "Angle", "Above, degrees", "At most, s"]
        yield table(wording, "Limits of the station: what breaks one is left out.", header, limits)


def outcome_words(outcome: Outcome, assessment: StationAssessment, wording: Wording) -> str:
    """What became of a motion, in words."""
    if outcome.usable:
        judged = next(each for each in assessment.judged if each.doing == outcome.doing)
        return wording.light(judged.level)
    return why_left_out(outcome, wording)


def why_left_out(outcome: Outcome, wording: Wording) -> str:
    """Why a motion is of no use, in words."""
    if outcome.breaches:
        numbers = ", ".join(
            f"{each.limit + 1} ({wording.number(ShownSeconds(each.seconds))}\u00a0s)" for each in outcome.breaches
        )
        return f"✕ {wording.say('breaks limit {numbers}', numbers=numbers)}"
    if outcome.kind == "too_weak":
        joint = wording.catalogue.term(format_label(outcome.joint)) if outcome.joint else wording.say("the body")
        return f"✕ {wording.say('too weak: {joint}', joint=joint)}"
    if outcome.kind == "missed":
        if outcome.missed_m is None:
            return f"✕ {wording.say('not reached')}"
        return f"✕ {wording.say('misses by {away:.0f} cm', away=100 * outcome.missed_m)}"
    findings = "; ".join(wording.catalogue.term(each.text) for each in outcome.findings)
    return f"✕ {wording.say('implausible: {findings}', findings=findings or wording.say('see the file'))}"


def _outcomes(assessment: StationAssessment, wording: Wording) -> Table:
    ways = assessment.station.ways
    by_doing = {each.doing: each for each in assessment.outcomes}
    rows = [
        [
            wording.name(each.operation),
            wording.name(each.place),
            wording.worker(each.worker),
            *(
                outcome_words(by_doing[Doing(each.worker, each.operation, each.place, way)], assessment, wording)
                for way in ways
            ),
        ]
        for each in assessment.places
    ]
    caption = wording.say(
        "Every worker at every place in every way: the level, or why it is left out. arm: trunk upright; back: upper "
        "arm hanging, trunk bent; squat: trunk upright, knees bent. All of it is in {file}.",
        file=f"`{OUTCOMES}`",
    )
    names = [wording.say(name) for name in ("Operation", "Place", "Worker")]
    return Table(caption, [*names, *map(wording.catalogue.term, ways)], rows)


def _left_out(assessment: StationAssessment, wording: Wording) -> Iterator[AnyBlock]:
    if excluded := assessment.best.excluded.values():
        yield Text(wording.say("What is left out, so that nothing is recommended that a rule forbids:"))
        yield Points([wording.sentence(each) for each in excluded])


def _population(assessment: StationAssessment, wording: Wording) -> Table:
    term = wording.catalogue.term
    rows = []
    for each in assessment.shares:
        statures = "–"
        if each.shortest_m is not None and each.tallest_m is not None:
            statures = wording.say("{low:.0f} to {high:.0f}", low=100 * each.shortest_m, high=100 * each.tallest_m)
        span = wording.say("{low:.0%} to {high:.0%}", low=each.share_low, high=each.share_high)
        strong = "–" if each.strong_share is None else wording.percent(each.strong_share)
        joint = term(statements.joint_name(each.weakest_joint)) if each.weakest_joint else "–"
        where, share = (wording.name(each.operation), wording.name(each.place)), wording.percent(each.share)
        rows.append([*where, term(each.sex), share, span, statures, strong, joint])
    header = ["Operation", "Place", "Sex", "Reach it", "With 3 cm less or more reach",
              "Statures tried that reach it, cm", "Strong enough", "Weakest joint"]  # fmt: skip
    caption = "Shares of the women and men of the population; strength at the median stature."
    return table(wording, caption, header, rows)


def _changes(assessment: StationAssessment, wording: Wording) -> Iterator[AnyBlock]:
    if assessment.changes:
        rows = [
            [
                wording.sentence(each.change)[:-1],
                ", ".join(wording.name(place) for place in each.places.values()) or "–",
                *("–" if one is None else wording.percent(one) for one in (each.saving, each.saving_everywhere)),
                "–" if each.peak is None else wording.percent(each.peak),
                wording.number(each.reached_by_all),
                wording.say("{allowed} of {of_places}", allowed=each.allowed, of_places=each.of_places),
            ]
            for each in assessment.changes
        ]
        header = ["Change", "Recommended after it", "Fatigue saved", "Saved over all places",
                  "Highest fatigue after it", "Places possible for all", "Places allowed"]  # fmt: skip
        yield table(wording, "What one change alone would do, each computed.", header, rows)
    yield from (Text(wording.sentence(each)) for each in front.planning(assessment))


def _pictures(assessment: StationAssessment, postures: Mapping[Doing, Posture], wording: Wording) -> Iterator[AnyBlock]:
    caption = "Every place that is reached, in the best way of the worker, where a rule finds it worst."
    yield Text(wording.say(caption))
    yield PostureRow(
        [figure_of(posture, wording, wording.name(doing.operation)) for doing, posture in postures.items()]
    )

"""The page of a station: complete, alone, readable by all, in every language; and the comparison of two assessments."""

import ast
import json
import re
import string
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import PRINTED_PX, chromium, needs_chromium, printed_when_legible
from commands import fatplan
from conftest import ROOT

from fatigue_planner.core.files import find_shipped
from fatigue_planner.core.settings import load_data
from fatigue_planner.ergonomics.indicator import INDICATORS
from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.registry import evaluate
from fatigue_planner.ergonomics.result import ORIGINS, Level, Phrase, ShownSeconds
from fatigue_planner.ergonomics.stated import Circumstances
from fatigue_planner.experiment.pose_grid import point_name
from fatigue_planner.fatigue.entries import ENTRIES, JOINT_GROUPS
from fatigue_planner.fatigue.model import CycleMap
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.motion.plausibility import BARS, Finding
from fatigue_planner.output.reports.station import catalogue as texts
from fatigue_planner.output.reports.station.catalogue import Catalogue, catalogue_of, languages
from fatigue_planner.output.reports.station.compare import BETTER, SAME, WORSE, compare_stations
from fatigue_planner.output.reports.station.compare_page import comparison_page
from fatigue_planner.output.reports.station.front import planning
from fatigue_planner.output.reports.station.maps import maps
from fatigue_planner.output.reports.station.page import pictured, station_page
from fatigue_planner.output.reports.station.pictures import Posture
from fatigue_planner.output.reports.station.stored import StoredAssessment
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.robot.scan import Standpoint
from fatigue_planner.robot.settings import RobotBase, RobotSettings
from fatigue_planner.station.assessment import (
    BestPlaces,
    Change,
    Doing,
    Fatigue,
    Judged,
    Kind,
    Outcome,
    PlaceForWorker,
    PlaceSummary,
    ReachShare,
    RobotFinding,
    RobotMeeting,
    RobotPlace,
    Rotation,
    Rule,
    Sensing,
    StationAssessment,
    WholeCycle,
)
from fatigue_planner.station.changes import LIGHTER
from fatigue_planner.station.cycles import Course
from fatigue_planner.station.limits import Breach, Limit
from fatigue_planner.station.loader import load_station
from fatigue_planner.station.recommendation import best_of, excluded, places_for_workers, ranked, summaries
from fatigue_planner.station.robot_reach import CANNOT_PRESENT, TOO_NEAR
from fatigue_planner.station.schema import Place, Station
from fatigue_planner.station.statements import (
    BROKEN,
    NOT_ACCEPTABLE,
    assumptions_of,
    headline_of,
    of_robot,
    rules_named,
)
from fatigue_planner.station.tables import INDICATOR_COLUMNS, indicator_rows, plain, write
from fatigue_planner.station.workers import facts_of

PACKAGE = ROOT / "fatigue_planner"
ENTRY = "right_shoulder_flexion:positive"
MAX_BYTES = 3_000_000
KINDS: dict[str, Kind] = {"overhead": "missed", "door": "reached", "floor": "too_weak"}


def line() -> Station:
    """The car line that ships, with a limit and a map."""
    found = load_station(find_shipped(Path("car_line")))
    places = {name: each.model_copy(update={"map": "line"}) for name, each in found.places.items()}
    found = found.model_copy(update={"places": places})
    limits = (Limit(measure="upper_arm_elevation", above_deg=60, at_most_s=2),)
    robot = RobotSettings(arm="ur5e", base_m=RobotBase(x=1.1, y=-0.25, z=0.0))
    return found.model_copy(update={"limits": limits, "robot": robot})


def robot_of(station: Station) -> RobotFinding:
    """One place too far, one too near, one presented."""
    cannot, worker = "out of reach by 18 cm", next(iter(station.workers))
    named: dict[str, str | float] = {"place": "overhead", "arm": "UR5e"}
    near: dict[str, str | float] = {"distance_cm": 3, "part": "right forearm", "worker": worker, "limit_m": 0.05}
    left_out = {"overhead": Phrase(CANNOT_PRESENT, named | {"reason": cannot}), "floor": Phrase(TOO_NEAR, named | near)}
    met = {place: RobotMeeting(worker, "back", 0.03, "right forearm", 5.2) for place in ("door", "floor")}
    why = {"overhead": cannot}
    places = tuple(
        RobotPlace(
            "fit", place, why.get(place, ""), (0.0,) * 6, 31.0, "wrist_1", 0.08, met.get(place), left_out.get(place)
        )
        for place in KINDS
    )
    reached = {(1.1, 0): 2, (1.1, 0.5): 3, (0.9, 0): 2, (0.9, 0.5): 3}
    return RobotFinding("UR5e", "", 5, places, tuple(Standpoint(*at, count) for at, count in reached.items()))


def outcomes_of(station: Station) -> Iterator[Outcome]:
    """One motion of each: reached, missed, too weak, implausible, and one that breaks a limit."""
    for worker, place, way in product(station.workers, KINDS, station.ways):
        outcome = Outcome(Doing(worker, "fit", place, way), ("right",), KINDS[place])
        if place == "overhead":
            outcome = replace(outcome, missed_m=0.123)
        elif place == "floor":
            outcome = replace(outcome, joint="lumbar_flexion")
        elif way == "back":
            finding = Finding("trunk_twist_deg", 31.0, 15.0, BARS["trunk_twist_deg"].describe(31.0, ""))
            outcome = replace(outcome, kind="implausible", findings=(finding,))
        elif way == "squat":
            outcome = replace(outcome, breaches=(Breach(0, 4.0),))
        yield outcome


@pytest.fixture(scope="module")
def assessment(reactions: tuple[Reaction, ...]) -> StationAssessment:
    """A made assessment with something of everything; its motion is one of the paper's."""
    station = line()
    operation = Operation.of(reactions[0], Circumstances(), "fit")
    judgements = {each.indicator: each for each in evaluate([operation])}
    outcomes = list(outcomes_of(station))
    fatigue = Fatigue(0.31, ENTRY, 0.01, 12, ENTRY)
    rule = Rule("iso_11226", judgements["iso_11226"].title, Level.NOT_ACCEPTABLE, 25.0, "right upper arm raised")
    judged = {
        each.doing: Judged(each.doing, Level.INVESTIGATE, (rule,), (), fatigue, judgements)
        for each in outcomes
        if each.usable
    }
    places = places_for_workers(station, outcomes, judged)
    found = summaries(station, places, judged)
    best = BestPlaces({"fit": "door"}, 0.31, 0.01, {}, None, excluded(station, places, judged))
    doings = [each.outcome.doing for each in places if each.way is not None]
    cycles = tuple(WholeCycle(d.worker, (d,), True, Level.INVESTIGATE, fatigue, judgements) for d in doings)
    return StationAssessment(
        station=station,
        workers=tuple(facts_of(station, name) for name in station.workers),
        outcomes=tuple(outcomes),
        judged=tuple(judged.values()),
        places=tuple(places),
        summaries=tuple(found),
        best=best,
        cycles=cycles,
        shares=(ReachShare("fit", "door", "female", 1.5, 1.8, 0.9, 0.8, 0.95, 0.99, ENTRY),),
        changes=(Change(Phrase(LIGHTER, {"tool": "gun"}), {"fit": "door"}, 0.2, 0.005, 0.5, 0.4, 1, 1, 3),),
        rotation=Rotation(({"fit": "door"}, {"fit": "floor"}), 0.1, True),
        sensing=Sensing(0.012, 0.004, 0.021, 0.034, False),
        headline=headline_of(station, places, found, best, cycles),
        assumptions=assumptions_of(station),
        station_digest="0123456789abcdef0123",
        version="0.0.0",
        robot=robot_of(station),
    )


@pytest.fixture(scope="module")
def postures(assessment: StationAssessment, reactions: tuple[Reaction, ...]) -> dict[Doing, Posture]:
    judged = {each.doing: each for each in assessment.judged}
    seen = Operation.of(reactions[0]).posture
    tick = reactions[0].motion.middle("work")
    goals = reactions[0].key.motion_request().action.goals()
    target = next(iter(goals.values())).path()[0].position_m.vector()
    time_s = tick * reactions[0].motion.time_step_s
    return {
        doing: Posture(judged[doing], reactions[0], ("right",), (target,), tick, time_s, seen)
        for doing in pictured(assessment)
    }


@pytest.fixture(scope="module")
def pages(assessment: StationAssessment, postures: dict[Doing, Posture]) -> dict[str, tuple[str, Catalogue]]:
    found = {language: catalogue_of(language) for language in languages()}
    return {language: (station_page(assessment, postures, each), each) for language, each in found.items()}


class Reader(HTMLParser):
    """The tags of a page in their order, and its text."""

    VOID = ("meta", "link")

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


def words(text: str) -> str:
    return re.sub(r"\s+", " ", text.replace("\u00a0", " ").replace("`", ""))


@pytest.mark.parametrize("language", languages())
def test_the_page_stands_alone_and_everybody_can_read_it(
    pages: dict[str, tuple[str, Catalogue]], language: str
) -> None:
    page = pages[language][0]
    assert len(page.encode()) <= MAX_BYTES
    assert not re.search(r"<script|\bsrc=|https?:|url\(|@import", page)
    read = Reader(page)
    assert read.open == []
    assert read.all("html") == [{"lang": language}]
    levels = [int(tag[1]) for tag, _ in read.tags if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert {cell["scope"] for cell in read.all("th")} == {"col", "row"}
    assert all(svg["role"] == "img" and svg["aria-label"] for svg in read.all("svg"))
    assert len(read.all("svg")) > 1 and len(read.all("caption")) == len(read.all("table"))
    names = [attributes["id"] for _, attributes in read.tags if "id" in attributes]
    assert len(names) == len(set(names))
    assert {link["href"] for link in read.all("a")} == {f"#{name}" for name in names}


@pytest.mark.parametrize("language", languages())
def test_the_page_is_complete(
    assessment: StationAssessment, pages: dict[str, tuple[str, Catalogue]], language: str
) -> None:
    page, catalogue = pages[language]
    text, wording = words(Reader(page).text), Wording(catalogue, assessment.workers)
    said_first = (*assessment.headline, *planning(assessment), *assessment.assumptions)
    for phrase in (*said_first, *of_robot(assessment.station, assessment.robot), *assessment.best.excluded.values()):
        assert words(wording.sentence(phrase)) in text
    for judgement in assessment.judged[0].judgements.values():
        for said in (judgement.title, judgement.edition, judgement.origin.words):
            assert words(catalogue.term(said)) in text
        assert words(wording.value(judgement)).removeprefix(wording.say("does not apply: {reason}", reason="")) in text
    cells = re.findall(r"<td[^>]*>(?:✕ )([^<]*)", page)
    assert assessment.robot is not None
    left_out = [each for each in assessment.robot.places if each.left_out is not None]
    assert len(cells) == sum(not each.usable for each in assessment.outcomes) + len(left_out)
    assert assessment.station_digest[:16] in text and assessment.version in text


@pytest.mark.parametrize("language", languages())
def test_the_page_names_percentiles_and_no_persons(
    assessment: StationAssessment, pages: dict[str, tuple[str, Catalogue]], language: str
) -> None:
    page, catalogue = pages[language]
    for name in assessment.station.workers:
        assert name not in page and name.replace("_", " ") not in page
    assert catalogue.text("woman P{percentile:.0f}", percentile=5) in page


def test_workers_of_the_same_percentiles_are_told_apart(assessment: StationAssessment) -> None:
    same = [replace(assessment.workers[0], name=name) for name in ("a", "b")]
    wording = Wording(catalogue_of("en"), same)
    assert (wording.worker("a"), wording.worker("b")) == ("woman P5 (1)", "woman P5 (2)")


def test_the_first_side_says_what_counts(pages: dict[str, tuple[str, Catalogue]]) -> None:
    first = words(Reader(pages["en"][0]).text.partition("Details")[0])
    for said in (
        "Woman P5 cannot reach overhead: the hand stays 12 cm away.", "is too weak for floor", "Best for fit: door.",
        "The most tired joint is right shoulder flexion of woman P5: it loses 31 % of its strength.",
        "investigate", "is not stated: RULA",
        "Gun 1 kg lighter: 1 of 3 places possible for all, 1 allowed, 40 % less fatigue.",
        "right upper arm raised) for 25 of 42 s",
    ):  # fmt: skip
        assert said in first, said


@pytest.mark.parametrize(
    ("sensing", "said"),
    [
        (
            Sensing(0.012, 0.004, 0.021, 0.034, False),
            "saves 1.2 % (0.4 % to 2.1 %) of the cost of fatigue over the best",
        ),
        (
            Sensing(0.002, -0.001, 0.005, 0.034, False),
            "nothing that can be shown over the best schedule: −0.1 % to 0.5 %",
        ),
        (Sensing(0.0, 0.0, 0.0, 0.034, False), "sensing saves nothing; no plan can save more than 3.4 % of the cost"),
        (Sensing(0.0, 0.0, 0.0, 0.0, True), "every worker has one way to work at each allowed place"),
        (None, "Planning with sensing saves nothing: there is no choice between allowed places."),
    ],
)
def test_the_page_says_what_planning_with_sensing_adds(
    assessment: StationAssessment, sensing: Sensing | None, said: str
) -> None:
    for language in languages():
        wording = Wording(catalogue_of(language), assessment.workers)
        last = [words(wording.sentence(each)) for each in planning(replace(assessment, sensing=sensing))][-1]
        assert not wording.catalogue.missing and (language != "en" or said in last)


def test_what_a_rule_forbids_is_left_out_and_never_recommended(assessment: StationAssessment) -> None:
    """The door, forbidden to one of three workers: excluded for all, in no ranking; the first lines name its rule."""
    station = assessment.station
    reached = [replace(each, kind="reached", breaches=(), findings=()) for each in assessment.outcomes]
    alone = {each.doing: replace(assessment.judged[0], doing=each.doing) for each in reached}
    rules = tuple(Rule(kind, kind, Level.NOT_ACCEPTABLE, seconds, "") for kind, seconds in (("a", 3.0), ("b", 20.0)))
    for doing, judged in alone.items():
        if doing.place == "door" and doing.worker == "tall_man":
            alone[doing] = replace(judged, level=Level.NOT_ACCEPTABLE, by=rules)
    places = places_for_workers(station, reached, alone)
    out = excluded(station, places, alone)
    assert {place for _, place in out} == {"door"} and "a, b" in str(out["fit", "door"])
    course = Course(*(CycleMap(np.full(2, 0.5), np.full(2, 0.1)) for _ in range(3)))
    ranking = ranked(station, places, out, dict.fromkeys(alone, course))
    assert {each.places for each in ranking} == {("overhead",), ("floor",)}
    lines = headline_of(station, places, summaries(station, places, alone), best_of(station, ranking, out, None), ())
    assert "fit at door is not acceptable for 20 of 42 s by b (20 s), a (3 s)" in map(str, lines)
    assert not any(str(line) == "Best for fit: door" for line in lines)


def test_a_time_of_less_than_a_second_is_not_none() -> None:
    """Not `0 of 42 s`; and a language's decimal sign also inside the list of rules."""
    rule = Rule("rula", "RULA", Level.NOT_ACCEPTABLE, 0.26, "right trunk")
    assert rules_named([rule]) == "RULA (right trunk, 0.3 s)"
    named: dict[str, str | float] = {
        "operation": "fit",
        "place": "door",
        "cycle_s": 42.0,
        "seconds": ShownSeconds(0.26),
    }
    phrase = Phrase(NOT_ACCEPTABLE, named | {"rules": rules_named([rule])})
    assert str(phrase) == "fit at door is not acceptable for 0.3 of 42 s by RULA (right trunk, 0.3 s)"
    german = Wording(catalogue_of("de"), ())
    assert (
        german.sentence(phrase) == "Fit bei door ist 0,3 von 42 s lang nicht annehmbar nach RULA (Rumpf rechts, 0,3 s)."
    )
    assert not german.catalogue.missing and german.rules([rule], 42.0) == "RULA (Rumpf rechts) 0,3 von 42 s"
    printed = [f"{ShownSeconds(seconds):.0f}" for seconds in (0, 0.02, 0.94, 0.96, 1.4, 12.5)]
    assert printed == ["0", "0.1", "0.9", "1", "1", "12"]


def test_without_an_allowed_place_nothing_is_recommended(
    assessment: StationAssessment, postures: dict[Doing, Posture]
) -> None:
    none = replace(assessment, best=BestPlaces({}, None, None, {}, None, assessment.best.excluded))
    page = words(Reader(station_page(none, postures, catalogue_of("en"))).text)
    assert "What one change would do is not computed" not in page  # it is
    tried = replace(none, changes=())
    assert "is not computed (--changes)." in words(Reader(station_page(tried, postures, catalogue_of("en"))).text)
    assert "No cycle is recommended." in page and "(recommended)" not in page and "least bad" in page


def test_nobody_reaches_anything(assessment: StationAssessment, tmp_path: Path) -> None:
    missed = tuple(replace(each, kind="missed", breaches=()) for each in assessment.outcomes)
    places = tuple(places_for_workers(assessment.station, missed, {}))
    nobody = replace(
        assessment, outcomes=missed, judged=(), places=places, cycles=(), changes=(), rotation=None, sensing=None,
        summaries=tuple(summaries(assessment.station, places, {})), best=BestPlaces({}, None, None, {}, None, {}),
    )  # fmt: skip
    page = words(Reader(station_page(nobody, {}, catalogue_of("de"))).text)
    assert "Kein Bild: Niemand erreicht einen Ort." in page
    write(nobody, tmp_path, "{}")
    header = ",".join(INDICATOR_COLUMNS)
    assert (tmp_path / "indicators.csv").read_text(encoding="utf-8").splitlines() == [header]
    assert all(list(row) == INDICATOR_COLUMNS for row in indicator_rows(assessment))


def grid_of(station: Station) -> Station:
    """The same with a rack of six places instead of the door."""
    points = {point_name("rack", {"x": x, "z": z}): (x, z) for x in (0.3, 0.45, 0.6) for z in (0.9, 1.4)}
    at = {name: Place(x=x, y=-0.1, z=z, tool="gun", map="rack") for name, (x, z) in points.items()}
    fit = station.operations["fit"].model_copy(update={"places": tuple(at)})
    return station.model_copy(update={"places": at, "operations": {"fit": fit}})


@pytest.mark.slow
@needs_chromium
@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("copies", [1, 5])
def test_the_fullest_first_side_is_one_sheet_of_paper(
    assessment: StationAssessment, postures: dict[Doing, Posture], language: str, copies: int, tmp_path: Path
) -> None:
    """With more sentences and places than it takes; and no width is too small for the page."""
    shelf, station = assessment.summaries[0], assessment.station
    many = {f"shelf_z{number}": station.places[shelf.place] for number in range(20)}
    assert assessment.robot is not None
    too_far = next(each for each in assessment.robot.places if each.reason)
    assert too_far.left_out is not None
    rules = "RULA (right trunk, 7 s), EN 1005-4 (trunk bent, 7 s), OWAS (legs, 7 s)"
    named: dict[str, str | float] = {"operation": "fit", "place": "shelf_z9_of_the_long_rack", "rules": rules}
    forbidden = Phrase(NOT_ACCEPTABLE, named | {"seconds": 7, "cycle_s": 42})
    broken = Phrase(BROKEN, named | {"worker": "small_woman", "limit": 1, "seconds": 11, "at_most_s": 5})
    full = replace(
        assessment,
        station=station.model_copy(update={"places": station.places | many}),
        headline=assessment.headline * copies + (forbidden,) * 7 + (broken,) * 7,
        summaries=assessment.summaries + tuple(replace(shelf, place=name) for name in many),
        robot=replace(
            assessment.robot,
            places=assessment.robot.places
            + tuple(
                replace(
                    too_far,
                    place=name,
                    left_out=too_far.left_out._replace(
                        values={**too_far.left_out.values, "place": f"{name}_of_the_long_rack"}
                    ),
                )
                for name in many
            ),
        ),
    )
    (tmp_path / "page.html").write_text(station_page(full, postures, catalogue_of(language)), encoding="utf-8")
    with chromium(tmp_path / "profile") as page:
        printed_when_legible(page, (tmp_path / "page.html").as_uri())
        end = "document.querySelector('.front').getBoundingClientRect().bottom + scrollY"  # the title is above it
        assert 0.8 * PRINTED_PX[1] < page.value(end) < PRINTED_PX[1]


@pytest.mark.parametrize("language", languages())
def test_a_grid_of_places_is_drawn_as_a_map(assessment: StationAssessment, language: str) -> None:
    """Every place once, at its row and column, with its level as a sign, who cannot, fatigue, rule and score."""
    station = grid_of(assessment.station)
    rules, judged = assessment.judged[0].by, assessment.judged[0]
    names = list(station.operations["fit"].places)
    levels = [Level.ACCEPTABLE, Level.INVESTIGATE, Level.NOT_ACCEPTABLE, Level.NOT_ACCEPTABLE, None, None]
    found = tuple(
        PlaceSummary(
            "fit", name, ("tall_man",) if level is not None else (), ("small_woman",) if i in (3, 4, 5) else (), level,
            rules if level else (), (), None if level is None else 0.1 * (i + 1), "" if level is None else ENTRY, 0.01,
        )
        for i, (name, level) in enumerate(zip(names, levels, strict=True))
    )  # fmt: skip
    doing = Doing("tall_man", "fit", names[1], "arm")
    place = PlaceForWorker("tall_man", "fit", names[1], "arm", Level.INVESTIGATE, Outcome(doing, ("right",), "reached"))
    robot = replace(robot_of(assessment.station), places=(
        RobotPlace("fit", names[2], "", (0.0,) * 6, 31.0, "wrist_1", 0.08, None, Phrase(CANNOT_PRESENT, {
            "place": names[2], "arm": "UR5e", "reason": "out of reach by 18 cm"})),
        RobotPlace("fit", names[1], "", (0.0,) * 6, 31.0, "wrist_1", 0.08, None, None),
    ))  # fmt: skip
    made = replace(
        assessment, robot=robot, station=station, summaries=found, places=(place,),
        judged=(replace(judged, doing=doing),), best=BestPlaces({"fit": names[0]}, 0.1, 0.01, {}, None, {}),
    )  # fmt: skip
    wording = Wording(catalogue_of(language), assessment.workers)
    (drawn,) = maps(made, wording)
    assert not wording.catalogue.missing and drawn.words in drawn.svg
    assert all(f" {count} " in f" {drawn.words} " for count in (6, 1, 2))
    cells = re.findall(r"<g><title>([^<]*)</title>(.*?)</g>", drawn.svg)
    texts_of = [re.findall(r"<text[^>]*>([^<]*)", inside) for _, inside in cells]
    told = dict(zip(names, texts_of, strict=True))
    percent = [wording.percent(0.1 * (i + 1)) for i in range(6)]
    score = judged.judgements["rula"].value
    assert score is not None
    assert list(told.values()) == [
        ["★ ●", percent[0]], ["▲ 1", percent[1], f"R {score.low:.0f}"], ["⊘ ■ 1", percent[2]],
        ["■ 1", percent[3], "✕ 1"], ["✕"], ["✕"],
    ]  # fmt: skip
    assert all(wording.name(name) in title for name, (title, _) in zip(names, cells, strict=True))
    assert wording.worker("small_woman") in cells[3][0] and "ISO 11226" in cells[3][0]
    dashed = ["stroke-dasharray" in inside for _, inside in cells]
    assert dashed == [False, False, False, True, True, True]
    hatched = ["<path" in inside for _, inside in cells]
    assert hatched == [level == Level.NOT_ACCEPTABLE for level in levels]
    corners = [tuple(map(float, re.search(r'rect x="([\d.]+)" y="([\d.]+)"', inside).groups())) for _, inside in cells]  # type: ignore[union-attr]
    columns, rows = (sorted({corner[axis] for corner in corners}) for axis in (0, 1))
    assert [(columns.index(x), rows.index(y)) for x, y in corners] == [(0, 1), (0, 0), (1, 1), (1, 0), (2, 1), (2, 0)]
    assert any("1 ISO 11226" in line for line in drawn.legend)
    assert "UR5e" in cells[2][0] and sum(line.startswith("⊘") for line in drawn.legend) == 1
    without = replace(made, robot=None)
    assert "⊘" not in "".join(line + one.svg for one in maps(without, wording) for line in one.legend)


# The catalogues.


def arguments_of(tree: ast.AST, name: str) -> Iterator[ast.expr]:
    """The first arguments of the calls of a function or method."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and node.args:
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called == name:
                yield node.args[0]


def constants(tree: ast.AST) -> set[str]:
    found = {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str)}
    return found | set(added_up(tree))


def added_up(tree: ast.AST) -> Iterator[str]:
    """Texts that a function writes in two lines: `text = "..."` and `text += "..."`."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            parts = [each.value for each in function.body if isinstance(each, ast.Assign | ast.AugAssign)]
            both = [each.value for each in parts if isinstance(each, ast.Constant) and isinstance(each.value, str)]
            if any(isinstance(each, ast.AugAssign) for each in function.body):
                yield "".join(both)


SOURCES = [
    *sorted((PACKAGE / "ergonomics").rglob("*.py")),
    *sorted((PACKAGE / "station").rglob("*.py")),
    *sorted((PACKAGE / "output" / "reports" / "station").glob("*.py")),
    PACKAGE / "robot" / "reach.py",
    PACKAGE / "motion" / "plausibility.py",
]
TREES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES}


def templates() -> set[str]:
    """Every literal that is said as a sentence; those with an f-string as a pattern, `{}` for what is put in."""
    found = set()
    for tree in TREES.values():
        for function in ("Phrase", "say", "text"):
            for argument in arguments_of(tree, function):
                found |= set(literals(argument))
        found |= set(added_up(tree))
    return found


def literals(node: ast.expr) -> Iterator[str]:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.IfExp):
        yield from (*literals(node.body), *literals(node.orelse))
    elif isinstance(node, ast.JoinedStr):
        yield "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)  # type: ignore[misc]


def capitals(path: Path) -> Iterator[str]:
    """The sentences among the capital constants of a module: those with a space."""
    for node in TREES[path].body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id.isupper():
            yield from (each for each in constants(node.value) if " " in each)


def vocabulary() -> set[str]:
    """Words that come as values: joints, bodies, sexes, ways, levels, and what the methods are called."""
    joints = {re.sub("^(right|left) ", "", entry.partition(":")[0].replace("_", " ")) for entry in ENTRIES}
    bodies = {re.sub("^(right|left) ", "", body.replace("_", " ")) for body in BODIES}
    groups = {re.sub("^(right|left)_", "", group) for group in JOINT_GROUPS}
    found = {*joints, *bodies, *groups, *(level.words for level in Level), *ORIGINS.values()}
    for kind in INDICATORS.kinds().values():
        if kind.__module__.startswith("fatigue_planner."):
            said: Any = getattr(kind, "words", ())
            found |= {kind.title, kind.edition, *(said.values() if isinstance(said, dict) else said)}
    return found


OTHERS = [language for language in languages() if language != "en"]


@pytest.mark.parametrize("language", OTHERS)
def test_no_text_is_missing(
    pages: dict[str, tuple[str, Catalogue]], language: str, assessment: StationAssessment
) -> None:
    catalogue = pages[language][1]
    assert not catalogue.missing
    keys = load_data(texts.TEXTS / f"{language}.yaml", texts.Texts).texts
    said = templates() | vocabulary()
    for name in ("statements", "recommendation", "changes", "examine", "robot_reach", "line/statements"):
        said |= set(capitals(PACKAGE / "station" / f"{name}.py"))
    missing = []
    for text in said - {""}:
        if "{}" in text:
            pattern = re.compile(".+".join(map(re.escape, text.split("{}"))))
            if not any(pattern.fullmatch(key) for key in keys):
                missing.append(text)
        elif text not in keys:
            missing.append(text)
    assert not missing


@pytest.mark.parametrize("language", OTHERS)
def test_no_text_is_stale(language: str) -> None:
    found = load_data(texts.TEXTS / f"{language}.yaml", texts.Texts)
    known = set().union(*map(constants, TREES.values())) | vocabulary()
    shown = {each.replace("_", " ") for each in known}
    parts = [text for text in templates() if "{}" in text]
    interpolated = [re.compile(".+".join(map(re.escape, text.split("{}")))) for text in parts]
    stale = [
        key for key in found.texts
        if key not in known and key not in shown and not any(pattern.fullmatch(key) for pattern in interpolated)
    ]  # fmt: skip
    assert not stale


@pytest.mark.parametrize("language", OTHERS)
def test_translations_have_the_values_of_the_english(language: str) -> None:
    found = load_data(texts.TEXTS / f"{language}.yaml", texts.Texts)
    for key, text in {**found.texts, **found.patterns}.items():
        assert fields_of(key) == fields_of(text), key
        assert text.strip() and (not key.endswith(".") or text.endswith(".")), key


def fields_of(text: str) -> list[tuple[str, str]]:
    return sorted((name, spec or "") for _, name, spec, _ in string.Formatter().parse(text) if name is not None)


@pytest.mark.parametrize(
    "reason",
    [
        "out of reach by 18 cm", "out of reach by less than 1 cm", "the arm would touch its pedestal",
        "the arm would touch itself or the ground", "the flange gets there, but cannot point where it should",
        "3.5 kg to hold; it carries 3 kg",
    ],
)  # fmt: skip
@pytest.mark.parametrize("language", OTHERS)
def test_what_stops_a_robot_is_translated(language: str, reason: str) -> None:
    catalogue = catalogue_of(language)
    assert catalogue.term(reason) != reason and not catalogue.missing


@pytest.mark.parametrize("language", OTHERS)
def test_every_finding_is_translated(language: str) -> None:
    catalogue = catalogue_of(language)
    for name, bar in BARS.items():
        english = bar.describe(
            1.25 * bar.most + 0.01, "right_forearm and thorax" if "parts" in bar.named_by else "left_hip_flexion"
        )
        found = catalogue.term(english)
        assert found != english and not catalogue.missing, name
    assert (
        catalogue.term("the place of the fist is 3.1 cm in the floor") != "the place of the fist is 3.1 cm in the floor"
    )


def test_german_numbers_and_words() -> None:
    german = catalogue_of("de")
    assert german.text("Shoes raise the worker by {shoes_cm:.1f} cm", shoes_cm=2.5) == "Schuhe erhöhen um 2,5 cm"
    assert german.number(0.305, ".0%") == "30\u00a0%" and german.number(-1.5, ".1f") == "−1,5"
    assert (
        german.term("RULA (right neck, 27 s), EN 1005-4 (trunk twisted)")
        == "RULA (Hals rechts, 27 s), EN 1005-4 (Rumpf verdreht)"
    )
    assert german.term("torque step within 40 ms at left hip flexion of 12.6 N.m (at most 10)") == (
        "Drehmomentsprung in 40 ms von 12,6 N·m: Hüfte (Beugung) links (höchstens 10)"
    )
    assert not german.missing
    assert german.term("unheard of") == "unheard of" and german.missing == {"unheard of"}


# Before and after.


def stored(assessment: StationAssessment) -> StoredAssessment:
    return StoredAssessment.model_validate_json(json.dumps(plain(assessment)))


@pytest.fixture(scope="module")
def better(assessment: StationAssessment) -> StationAssessment:
    """The same, with a door that is acceptable, and more fatigue in the cycle of the last worker."""
    found = tuple(
        replace(each, level=Level.ACCEPTABLE, by=()) if each.place == "door" else each for each in assessment.summaries
    )
    tired = replace(assessment.cycles[-1], fatigue=replace(assessment.cycles[-1].fatigue, peak=0.4))
    places = assessment.station.places
    moved = places | {"door": places["door"].model_copy(update={"z": 1.0})}
    station = assessment.station.model_copy(update={"places": moved})
    return replace(assessment, summaries=found, cycles=(*assessment.cycles[:-1], tired), station=station)


def test_a_comparison_says_what_got_better_and_what_worse(
    assessment: StationAssessment, better: StationAssessment
) -> None:
    found = compare_stations(stored(assessment), stored(better), catalogue_of("en"))
    assert {row.what: row.verdict for row in found.places} == {
        ("fit", "overhead"): SAME, ("fit", "door"): BETTER, ("fit", "floor"): SAME,
    }  # fmt: skip
    assert [row.verdict for row in found.cycles] == [SAME, SAME, WORSE]
    door = next(row for row in found.places if row.what[1] == "door")
    assert (words(door.before), words(door.after)) == (
        "▲ investigate: 25 s above the rule; right shoulder flexion loses 31 %",
        "● acceptable: right shoulder flexion loses 31 %",
    )
    assert found.settings == {"places.door.z": ("1.15", "1.0")}
    back = compare_stations(stored(better), stored(assessment), catalogue_of("en"))
    assert [row.verdict for row in back.cycles] == [SAME, SAME, BETTER]


def test_a_comparison_says_who_comes_nearer_where_nobody_can_yet(assessment: StationAssessment) -> None:
    """A place that stays left out may be better all the same, for a worker and for the population."""
    missed = next(each for each in assessment.places if each.outcome.kind == "missed")
    broken = replace(missed.outcome, kind="reached", missed_m=None, breaches=(Breach(0, 11.0),))
    lower = replace(
        assessment,
        places=tuple(replace(each, outcome=broken) if each is missed else each for each in assessment.places),
        shares=tuple(replace(each, share=0.98) for each in assessment.shares),
    )
    found = compare_stations(stored(assessment), stored(lower), catalogue_of("en"))
    assert {row.verdict for row in (*found.places, *found.cycles)} == {SAME}
    changed = [
        (row.what, words(row.before), words(row.after), row.verdict) for row in found.rows if row.verdict != SAME
    ]
    assert changed == [
        (("woman P5", "fit", "overhead"), "✕ misses by 12 cm", "✕ breaks limit 1 (11 s)", BETTER),
        (
            ("fit", "door", "female"),
            "reached by 90 %, strong enough: 99 %",
            "reached by 98 %, strong enough: 99 %",
            BETTER,
        ),
    ]
    back = compare_stations(stored(lower), stored(assessment), catalogue_of("en"))
    assert [row.verdict for row in back.rows if row.verdict != SAME] == [WORSE, WORSE]


def test_a_worker_of_a_name_may_be_another_one_after(assessment: StationAssessment) -> None:
    """Each side calls the workers by its own percentiles; a row says both."""
    station, name = assessment.station, assessment.workers[0].name
    other = station.workers[name].model_copy(update={"percentile": 50})
    changed = station.model_copy(update={"workers": station.workers | {name: other}})
    facts = (facts_of(changed, name), *assessment.workers[1:])
    found = compare_stations(
        stored(assessment), stored(replace(assessment, station=changed, workers=facts)), catalogue_of("en")
    )
    assert found.cycles[0].what == ("woman P5 → woman P50",) and found.cycles[1].what == ("man P95",)
    overhead = next(row for row in found.places if row.what[1] == "overhead")
    assert "woman P5," in overhead.before and "woman P50," in overhead.after
    assert found.settings == {"workers.woman P5 → woman P50.percentile": ("5.0", "50.0")}


@pytest.mark.parametrize("language", languages())
def test_the_page_of_a_comparison(assessment: StationAssessment, better: StationAssessment, language: str) -> None:
    catalogue = catalogue_of(language)
    read = Reader(comparison_page(compare_stations(stored(assessment), stored(better), catalogue)))
    assert read.open == [] and not catalogue.missing
    assert catalogue.text("What got better") in read.text and "small_woman" not in read.text


def test_compare_takes_the_folders_of_two_assessments(
    assessment: StationAssessment, better: StationAssessment, tmp_path: Path
) -> None:
    for name, each in (("before", assessment), ("after", better)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "assessment.json").write_text(json.dumps(plain(each)), encoding="utf-8")
    done = fatplan(
        "compare", "before", "after/assessment.json", "--save", "both.html", "--language", "de", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert "Was besser wurde:\n  fit, door: näher prüfen" in done.stdout
    assert (tmp_path / "both.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    document = json.loads(fatplan("compare", "before", "after", "--json", cwd=tmp_path).stdout)
    assert [row["verdict"] for row in document["places"]] == [SAME, BETTER, SAME]
    (tmp_path / "other").mkdir()
    (tmp_path / "old.json").write_text("{}")
    for reason, wrong in {
        "before is an assessment of a station, other is not": ("before", "other"),
        "old.json: is not an assessment of this version": ("before", "old.json"),
        "nothing.json: cannot be read": ("before", "nothing.json"),
        "--language xx: give one of de, en": ("before", "after", "--language", "xx"),
    }.items():
        refused = fatplan("compare", *wrong, cwd=tmp_path)
        assert refused.returncode == 2 and reason in refused.stderr

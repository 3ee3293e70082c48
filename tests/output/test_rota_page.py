"""The page of a line's rota: in every language, on one side of A4, without a word of what single workers bear."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from browser import PRINTED_PX, chromium, needs_chromium, printed_when_legible

from fatigue_planner.ergonomics.result import Assessment as Judgement
from fatigue_planner.ergonomics.result import Decides, Level, Origin, Phrase, Span
from fatigue_planner.fatigue.entries import JOINT_GROUPS
from fatigue_planner.output.reports.station.catalogue import catalogue_of, languages
from fatigue_planner.output.reports.station.rota import rota_page
from fatigue_planner.station.assessment import Fatigue
from fatigue_planner.station.line.advice import Advice
from fatigue_planner.station.line.demands import Demand
from fatigue_planner.station.line.loader import LoadedLine, load_line
from fatigue_planner.station.line.measures import MEASURES
from fatigue_planner.station.line.posts import STATED, Post
from fatigue_planner.station.line.program import Rota
from fatigue_planner.station.line.rotate import CrewRotation, Lifting
from fatigue_planner.station.line.slots import FREE
from fatigue_planner.station.statements import MISSED

ENTRY = "right_shoulder_flexion:positive"
HANDS = ("right_hand", "left_hand")
RULES = "RULA (right trunk, 11 s), EN 1005-4 (right upper arm raised far, 8 s)"


def line_of(stations: int, workers: int) -> LoadedLine:
    """So many of the stations and of the crew that ship, again and again."""
    shipped = load_line(Path("trim_line"))
    line = shipped.line
    names = [*line.stations]
    station_names = [f"{names[i % 3]}_{i // 3 + 1}" for i in range(stations)]
    crew = [*line.crew]
    made = line.model_copy(update={
        "stations": {name: line.stations[names[i % 3]] for i, name in enumerate(station_names)},
        "crew": {f"{crew[i % 3]}_{i // 3 + 1}": line.crew[crew[i % 3]] for i in range(workers)},
    })  # fmt: skip
    return LoadedLine(
        made,
        {name: shipped.stations[names[i % 3]] for i, name in enumerate(station_names)},
        dict.fromkeys(station_names, 42.0),
    )


def lifted_at(index: float) -> Judgement:
    """NIOSH's lifting index, and half as much again with poor coupling."""
    poor = Decides("", Phrase("with poor coupling"), 1.5 * index)
    return Judgement(
        "niosh_lifting", "NIOSH lifting index", "", Origin.AGREED, value=Span(index, poor.value), digits=1,
        levels=(Level.INVESTIGATE, Level.INVESTIGATE), decides=(poor,),
    )  # fmt: skip


def rotation_at(line: LoadedLine) -> CrewRotation:
    """A made rotation with something of everything: cannot, forbidden, free, lifting, not proven, no help."""
    stations, workers, slots = [*line.stations], [*line.line.crew], line.line.slots
    demand = Demand(42.0, np.zeros((0, 0)), {}, {})
    at = Post(demand, (), Level.ACCEPTABLE, "", Fatigue(0.31, ENTRY, 0.01, 12, ENTRY))
    forbidden = replace(at, level=Level.NOT_ACCEPTABLE, rules=RULES)
    missed = Post(None, (Phrase(MISSED, {"worker": workers[0], "place": "rail", "away_cm": 7.0}),))
    posts = {worker: dict.fromkeys(stations, at) for worker in workers}
    posts[workers[0]] |= {stations[1]: missed}
    posts[workers[1]] |= {stations[0]: STATED, stations[1]: forbidden}
    places = (np.arange(len(workers))[:, None] + np.arange(slots)) % len(workers)
    places = np.where(places < len(stations), places, FREE)
    burdens = np.linspace(0.5, 1.234, len(workers))
    rota = Rota(places, burdens, 1.1, 3.0, 2.9, 21, 20)
    advice = Advice(rota, 1.24, None, (2,), (2, 0.9))
    ratios = {
        worker: {kind: dict.fromkeys(HANDS if kind != "acceptable_effort" else JOINT_GROUPS, 0.111 * (n + 1))
                 for kind in MEASURES}
        for n, worker in enumerate(workers)
    }  # fmt: skip
    lifting = {
        workers[0]: Lifting(2.5, "long", {stations[0]: lifted_at(1.4)}),
        workers[1]: Lifting(8.5, None),
        workers[2]: Lifting(1.0, "short", {stations[0]: lifted_at(1.3)}),
    }
    return CrewRotation(line, posts, advice, ratios, lifting, (0.02, 0.034))


class Tags(HTMLParser):
    """The tags of a page that are open, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text += data


@pytest.mark.parametrize("language", languages())
def test_the_page_says_who_works_where_and_what_that_gains(language: str) -> None:
    found, texts = rotation_at(line_of(3, 4)), catalogue_of(language)
    page = rota_page(found, texts)
    assert not texts.missing
    assert not re.search(r"<script|\bsrc=|https?:|url\(|@import", page)
    read = Tags(page)
    assert read.open == []
    number = texts.number
    said = re.sub(r"\s+", " ", read.text.replace("\u00a0", " "))
    for shown in (
        number(1.234, ".2f"),
        number(1.24, ".2f"),
        number(0.9, ".2f"),
        f"{number(1.4, '.1f')} ({number(2.1, '.1f')} {texts.text('with poor coupling')}",
        "small woman 1",
        "clips 1",
        "1:49–2:58",
    ):
        assert shown in said
    rows = re.findall(r'<tr><th scope="row"[^>]*>([^<]*)</th>(.*?)</tr>', page, re.S)
    cells = [re.sub("<[^>]*>", "", cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", rows[0][1], re.S)]
    assert [name for name, _ in rows[:4]] == ["small woman 1", "median man 1", "tall man 1", "small woman 2"]
    assert number(1.3, ".1f") not in said
    assert cells == ["lamps 1", "seats 1", "clips 1", texts.text("free")] * 2
    sentences = {
        "en": ("Rotation does not help; redesign clips 1.", "Small woman 1 cannot reach rail: the hand stays 7 cm away",
               "Without the pause at 120 min, worked through: +2 %.", "duration long of NIOSH", "forget within min"),
        "de": ("Wechsel hilft nicht; clips 1 umgestalten.", "Small woman 1 erreicht rail nicht: Es fehlen 7 cm",
               "Ohne die Pause bei 120 min, durchgearbeitet: +2 %.", "Dauerklasse lang", "vergessen in Minuten"),
    }  # fmt: skip
    for sentence in sentences[language]:
        assert sentence in said


def test_what_a_single_worker_bears_is_not_on_the_page() -> None:
    """Only the largest of the crew is; the order is that of the file."""
    found = rotation_at(line_of(3, 4))
    page = rota_page(found, catalogue_of("en"))
    assert "0.44" in page and not any(shown in page for shown in ("0.11", "0.22", "0.33", "0.50", "0.74", "0.99"))


def test_a_line_that_cannot_be_manned_has_a_page_that_says_so() -> None:
    found = rotation_at(line_of(3, 3))
    page = rota_page(replace(found, advice=None, ratios={}, lifting={}, pauses=()), catalogue_of("en"))
    assert page.count("The stations cannot be manned all the time by those who can work at them.") >= 2
    assert "<h2>Rota</h2>" not in page


@pytest.mark.slow
@needs_chromium
@pytest.mark.parametrize("language", languages())
def test_the_page_is_for_everybody_and_fits_on_one_side(tmp_path: Path, language: str) -> None:
    (tmp_path / "page.html").write_text(
        rota_page(rotation_at(line_of(12, 12)), catalogue_of(language)), encoding="utf-8"
    )
    with chromium(tmp_path / "profile") as page:
        printed_when_legible(page, (tmp_path / "page.html").as_uri())
        bottom = "document.querySelector('.front').getBoundingClientRect().bottom + scrollY"
        assert 0.3 * PRINTED_PX[1] < page.value(bottom) < PRINTED_PX[1]
        table = "document.querySelector('.front table')"
        assert page.value(f"{table}.getBoundingClientRect().right <= innerWidth")

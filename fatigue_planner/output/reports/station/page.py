"""The page of an assessed station: one side for everybody, then details; no script, nothing loaded from elsewhere."""

from collections.abc import Mapping, Sequence
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from fatigue_planner.output.reports.page import prose
from fatigue_planner.output.reports.station.blocks import Part
from fatigue_planner.output.reports.station.catalogue import Catalogue
from fatigue_planner.output.reports.station.details import details
from fatigue_planner.output.reports.station.front import facts, front, shown, verdict
from fatigue_planner.output.reports.station.pictures import Posture
from fatigue_planner.output.reports.station.wording import Wording
from fatigue_planner.station.assessment import Doing, StationAssessment

PAGE = "assess.html"
# A page with more pictures is too heavy.
MAX_PICTURES = 60
# So much of a digest tells two files apart on paper.
SHOWN_DIGITS = 16


def station_page(assessment: StationAssessment, postures: Mapping[Doing, Posture], texts: Catalogue) -> str:
    """The page in a language, with the postures of the motions that are `pictured`."""
    wording = Wording(texts, assessment.workers)
    title = wording.say("Workstation {name}: ergonomic assessment", name=wording.name(assessment.station.name))
    footer = wording.say(
        "Station file {digest}, fatplan {version}. All numbers are in {json}. Same file and version, same page.",
        digest=f"`{assessment.station_digest[:SHOWN_DIGITS]}`", version=assessment.version, json="`assessment.json`",
    )  # fmt: skip
    return render(
        wording,
        title,
        footer,
        verdict(assessment, wording),
        front(assessment, postures, wording),
        list(details(assessment, postures, wording)),
        facts(assessment, wording),
    )


def pictured(assessment: StationAssessment) -> list[Doing]:
    """The motions that are drawn: those of the first side, and as many others as the page can have."""
    doings = [doing for _, doing in shown(assessment)]
    doings += [doing for cycle in assessment.cycles for doing in cycle.doings]
    doings += [each.outcome.doing for each in assessment.places if each.way is not None]
    return list(dict.fromkeys(doings))[:MAX_PICTURES]


def render(
    wording: Wording,
    title: str,
    footer: str,
    verdict: tuple[str, str],
    front: Sequence[Part],
    sections: Sequence[Part],
    facts: Sequence[tuple[str, str]] = (),
) -> str:
    """A page of sections: those of the first side without numbers, then those of the details with a list of them."""
    environment = _environment()
    environment.filters["marked"] = wording.marked
    return environment.get_template("station/page.html.j2").render(
        language=wording.catalogue.language,
        title=title,
        facts=facts,
        verdict=verdict,
        front=front,
        sections=sections,
        footer=footer,
        skip=wording.say("Skip to the content"),
        contents=wording.say("Details"),
    )


@cache
def _environment() -> Environment:
    loader = PackageLoader("fatigue_planner.output.reports", "")
    environment = Environment(loader=loader, autoescape=select_autoescape(["j2"]), undefined=StrictUndefined)
    environment.trim_blocks = environment.lstrip_blocks = True
    environment.filters |= {"prose": prose, "kind": lambda block: type(block).__name__}
    return environment

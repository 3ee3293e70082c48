"""What a station's page is made of besides texts and tables: groups of sentences, pictures, and maps."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from fatigue_planner.output.reports.page import Block, Section, Table
from fatigue_planner.output.reports.station.wording import Wording


@dataclass(frozen=True)
class Group:
    """Sentences under a small heading."""

    title: str
    items: Sequence[str]


@dataclass(frozen=True)
class Groups:
    """Groups beside each other where there is room."""

    groups: Sequence[Group]


@dataclass(frozen=True)
class PostureRow:
    """Pictures beside each other, as HTML figures."""

    figures: Sequence[Markup]


@dataclass(frozen=True)
class Map:
    """A picture of places: what it shows in words, its SVG, and what its signs mean."""

    words: str
    svg: Markup
    legend: Sequence[str]


AnyBlock = Block | Groups | PostureRow | Map


@dataclass(frozen=True)
class Part:
    """A part of the page with a heading."""

    title: str
    blocks: Sequence[AnyBlock]

    @property
    def anchor(self) -> str:
        """The name that links lead to."""
        return Section(self.title).anchor


def table(wording: Wording, caption: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """A table whose caption and header are texts of the catalogue."""
    return Table(wording.say(caption), [wording.say(name) for name in header], rows)

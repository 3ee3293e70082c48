"""What a station's page is made of besides texts and tables: groups of sentences, and pictures beside each other."""

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


AnyBlock = Block | Groups | PostureRow


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

"""One HTML page of sections of blocks: no script, nothing loaded from elsewhere, the same bytes every time."""

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import count
from typing import Literal

from jinja2 import Environment, PackageLoader, StrictUndefined, Template, select_autoescape
from markupsafe import Markup, escape

from fatigue_planner.output.figures.style import Picture

REPORT_FILE = "report.html"
_CODE = re.compile(r"`([^`]+)`")


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    words: str


@dataclass(frozen=True)
class Points:
    """A list of sentences."""

    items: Sequence[str]


@dataclass(frozen=True)
class Table:
    """A table of texts; columns of numbers stand to the right. data_file: where the values are in full."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    data_file: str | None = None

    def alignment(self) -> list[Literal["right", "left"]]:
        """How each column stands."""
        columns = [[cell for cell in column if cell not in {"", "–"}] for column in zip(*self.rows, strict=True)]
        sides: list[Literal["right", "left"]] = [
            "right" if cells and all(cell[0] in "0123456789−+±<" for cell in cells) else "left" for cells in columns
        ]
        return sides or ["left"] * len(self.header)


@dataclass(frozen=True)
class Code:
    """Commands or settings, as they are typed."""

    text: str


Block = Text | Points | Picture | Table | Code


@dataclass(frozen=True)
class Section:
    """A part of a page with a heading."""

    title: str
    blocks: Sequence[Block] = field(default_factory=tuple)

    @property
    def anchor(self) -> str:
        """The name that links lead to."""
        return "".join(letter if letter.isalnum() else "-" for letter in self.title.lower())


def as_text(section: Section) -> str:
    """A section's paragraphs and tables for a terminal, the columns of a table below each other."""
    lines = [f"{section.title}:"]
    for block in section.blocks:
        if isinstance(block, Text):
            lines.append(f"  {block.words}")
        elif isinstance(block, Table):
            rows = [block.header, *block.rows]
            widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
            lines.append(f"  {block.caption}")
            lines += ["    " + "  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
    return "\n".join(lines)


def page(title: str, subtitle: str, summary: Sequence[Block], sections: Sequence[Section]) -> str:
    """The page: a title, what one learns, and numbered sections with numbered figures and tables."""
    return _template().render(
        title=title, subtitle=subtitle, summary=summary, sections=sections, figures=count(1), tables=count(1)
    )


@cache
def _template() -> Template:
    loader = PackageLoader("fatigue_planner.output.reports", "")
    environment = Environment(loader=loader, autoescape=select_autoescape(["j2"]), undefined=StrictUndefined)
    environment.trim_blocks = environment.lstrip_blocks = True
    environment.filters |= {"prose": prose, "base64": _base64, "kind": lambda block: type(block).__name__}
    return environment.get_template("page.html.j2")


def prose(words: str) -> Markup:
    """Text in which `names` stand out; a per cent sign stays with its number where a line breaks."""
    return Markup(_CODE.sub(r"<code>\1</code>", str(escape(words)).replace(" %", "\u00a0%")))


def _base64(text: str) -> str:
    return base64.b64encode(text.encode()).decode()

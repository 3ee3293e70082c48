"""What a page is made of: sections of paragraphs, figures and tables, written from computed values only."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

BLANK = "\u00a0"


def significant(value: float, digits: int = 3) -> str:
    """A number with some significant digits; `n/a` where there is none."""
    return "n/a" if math.isnan(value) else f"{value:.{digits}g}".replace("-", "−")


def percent(share: float, digits: int = 2) -> str:
    """A share as per cent with some decimals; the sign stays with the number where a line breaks."""
    if math.isnan(share):
        return "n/a"
    rounded = round(100 * share, digits) + 0.0  # zero has no sign
    return f"{rounded:.{digits}f}{BLANK}%".replace("-", "−")


def percent_range(low: float, high: float, digits: int = 2) -> str:
    """An interval of shares as per cent."""
    return f"{percent(low, digits).removesuffix(f'{BLANK}%')} to {percent(high, digits)}"


def counted(number: int, what: str, several: str = "") -> str:
    """`1 run`, `2 runs`."""
    return f"{number} {what if number == 1 else several or what + 's'}"


def listing(items: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    words: str


@dataclass(frozen=True)
class Points:
    """A list of sentences."""

    items: Sequence[str]


@dataclass(frozen=True)
class Picture:
    """A figure: its SVG, what it shows, the same in words for those who cannot see it, and the file of its data."""

    svg: str
    caption: str
    alternative: str
    data_file: str


@dataclass(frozen=True)
class Table:
    """A table of texts; columns of numbers stand to the right. data_file: where the values are in full."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    data_file: str | None = None

    def alignment(self, column: int) -> Literal["right", "left"]:
        """How a column stands."""
        cells = [row[column] for row in self.rows if row[column] not in {"", "–"}]
        return "right" if cells and all(cell[0] in "0123456789−+±<" for cell in cells) else "left"


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

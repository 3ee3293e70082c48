"""What an indicator finds: a number or a range, what it means, where it is worst, and how far it is to be trusted."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from itertools import product
from math import isfinite
from typing import Any, NamedTuple


class Level(IntEnum):
    """One scale for all methods, beside the words of each method."""

    ACCEPTABLE = 0
    INVESTIGATE = 1
    NOT_ACCEPTABLE = 2

    @property
    def words(self) -> str:
        """As it is printed."""
        return self.name.lower().replace("_", " ")


class Origin(IntEnum):
    """How far a rule was checked, from the best to the worst."""

    READ = 0
    AGREED = 1
    RECALLED = 2

    @property
    def words(self) -> str:
        """As it is printed."""
        return ORIGINS[self]


ORIGINS = {
    Origin.READ: "read in its source",
    Origin.AGREED: "read in independent transcriptions that agree, not in its source",
    Origin.RECALLED: "recalled, not read in its source",
}


class Phrase(NamedTuple):
    """A sentence with its numbers apart, so that it can be translated: `template` is the key of a catalogue.

    Templates are literals where a phrase is made, so that a catalogue can be compared with the sources.
    """

    template: str
    values: Mapping[str, str | float] = {}

    def __str__(self) -> str:
        return self.template.format(**self.values)


class Span(NamedTuple):
    """A value from what is known: what it is at least and at most."""

    low: float
    high: float

    def text(self, digits: int) -> str:
        """`3` or `3 to 5`."""
        low, high = (printed(value, digits) for value in self)
        return low if low == high else f"{low} to {high}"


class ShownSeconds(float):
    """Seconds, of which less than one have a decimal where whole ones are printed: a short time is not none."""

    def __format__(self, spec: str) -> str:
        return format(max(float(self), 0.1), ".1f") if spec == ".0f" and 0 < self < 0.95 else format(float(self), spec)


def printed(value: float, digits: int) -> str:
    """A value with so many decimals; an infinite one as its sign."""
    return f"{value:.{digits}f}" if isfinite(value) else "∞"


class Decides(NamedTuple):
    """An input that is not stated, and what the value becomes if it turns out so."""

    key: str
    condition: Phrase
    value: float


class Unknown(NamedTuple):
    """An input that is not stated: the value that is taken first, and what else it may be and how that is said."""

    key: str
    first: Any
    others: tuple[tuple[Any, Phrase], ...]


def spanned(
    value_of: Callable[[Mapping[str, Any]], float], unknown: Sequence[Unknown]
) -> tuple[Span, float, tuple[Decides, ...]]:
    """The range over all that unknown inputs may be, the value for the first of each, and what each alone changes."""
    first = {one.key: one.first for one in unknown}
    base = value_of(first)
    decides = []
    for one in unknown:
        for other, condition in one.others:
            alone = value_of(first | {one.key: other})
            if alone != base:
                decides.append(Decides(one.key, condition, alone))
    choices = [(one.first, *(other for other, _ in one.others)) for one in unknown]
    keys = [one.key for one in unknown]
    values = [value_of(dict(zip(keys, chosen, strict=True))) for chosen in product(*choices)]
    return Span(min(values), max(values)), base, tuple(decides)


class Moment(NamedTuple):
    """Where the worst is: operation, seconds since its beginning, side (empty: none or both), part of the body."""

    operation: str
    time_s: float
    side: str
    part: str


class Times(NamedTuple):
    """Seconds per cycle in each level."""

    acceptable_s: float
    investigate_s: float
    not_acceptable_s: float


@dataclass(frozen=True)
class Assessment:
    """What an indicator says of a job.

    indicator, title     its kind, and how people call it
    edition              method, edition, variant of its tables
    origin               how far the rules were checked, the least checked of them
    applies              whether the method may be used here at all; if not, `reason` says why and no value is given
    value, digits, unit  the worst in the cycle; a range if inputs are not stated, and decimals to print
    levels               of both ends of the range; `words` are the method's own for them
    decides              the inputs that make it a range, each alone
    times, times_most    seconds per cycle in each level, at the low and at the high end; of methods that judge postures
    worst                where the worst is, at the low end
    parts                what the value is made of at the worst instant, by name
    remarks              what has to be known beside the value
    """

    indicator: str
    title: str
    edition: str
    origin: Origin
    applies: bool = True
    reason: Phrase | None = None
    value: Span | None = None
    digits: int = 0
    unit: str = ""
    levels: tuple[Level, Level] | None = None
    words: tuple[str, str] | None = None
    decides: tuple[Decides, ...] = ()
    times: Times | None = None
    times_most: Times | None = None
    worst: Moment | None = None
    parts: Mapping[str, float] = field(default_factory=dict)
    remarks: tuple[Phrase, ...] = ()

    def text(self) -> str:
        """The value with what decides it, in a line: `3 (4 if repeated more than 4 times a minute)`."""
        if self.value is None:
            return f"does not apply: {self.reason}"
        shown = self.value if not self.decides else Span(self.value.low, self.value.low)
        known = f"{shown.text(self.digits)} {self.unit}".rstrip()
        more = "; ".join(f"{printed(one.value, self.digits)} {one.condition}" for one in self.decides)
        most = f"; {printed(self.value.high, self.digits)} if all" if len(self.decides) > 1 else ""
        return f"{known} ({more}{most})" if more else known

    def plain(self) -> dict[str, Any]:
        """All of it as JSON values; levels and origin in words, an infinite number as the text "Infinity"."""
        return {
            "indicator": self.indicator,
            "title": self.title,
            "edition": self.edition,
            "origin": self.origin.words,
            "applies": self.applies,
            "reason": None if self.reason is None else str(self.reason),
            "value": None if self.value is None else {end: _finite(v) for end, v in self.value._asdict().items()},
            "unit": self.unit,
            "levels": None if self.levels is None else [level.words for level in self.levels],
            "words": None if self.words is None else list(self.words),
            "decides": [{"key": d.key, "condition": str(d.condition), "value": _finite(d.value)} for d in self.decides],
            "times": None if self.times is None else self.times._asdict(),
            "times_most": None if self.times_most is None else self.times_most._asdict(),
            "worst": None if self.worst is None else self.worst._asdict(),
            "parts": dict(self.parts),
            "remarks": [str(remark) for remark in self.remarks],
        }


def _finite(value: float) -> float | str:
    return value if isfinite(value) else "Infinity"

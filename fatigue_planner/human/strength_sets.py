"""Strength sets: maximum torques from files that may build on other files."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from statistics import NormalDist
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.core.settings import Settings, load_data
from fatigue_planner.human.skeleton import DATA, DEGREES_OF_FREEDOM, without_side

STRENGTHS = DATA / "strengths"
MAX_PATH_LENGTH = 1000
# Of files that are based on each other.
MAX_CHAIN_LENGTH = 10
LOWEST_PERCENTILE, HIGHEST_PERCENTILE = 1.0, 99.0
# A set at a percentile of strength: average_woman:p5.
_AT_PERCENTILE = re.compile(r"(.+):p([0-9]{1,2}(?:\.[0-9]{1,2})?)")

Direction = Literal["positive", "negative"]
Torque = Annotated[float, Field(gt=0, le=10_000)]
Entry = tuple[str, Direction]


class Strength(Settings):
    """Maximum isometric torque of a degree of freedom, in one direction or both, in N.m."""

    positive: Torque | None = None
    negative: Torque | None = None
    source: str

    @model_validator(mode="after")
    def _check_direction(self) -> Self:
        if self.positive is None and self.negative is None:
            raise ValueError("neither positive nor negative is given")
        return self


class StrengthFile(Settings):
    """Content of a strength file.

    Without `based_on` it holds every degree of freedom in both directions. With it (the name of a set
    that ships with the package, or a path relative to the file) it holds what differs. A name without
    side (`elbow_flexion`) means both sides; one with its side (`right_elbow_flexion`) goes before it.
    """

    population: str
    based_on: Annotated[str, Field(max_length=MAX_PATH_LENGTH)] | None = None
    degrees_of_freedom: dict[str, Strength]


@dataclass(frozen=True)
class StrengthEntry:
    """One entry of a strength set."""

    torque_nm: float
    source: str


@dataclass(frozen=True)
class StrengthSet:
    """A complete set: an entry for both directions of all 39 degrees of freedom."""

    population: str
    based_on: str | None
    entries: dict[Entry, StrengthEntry]


def shipped_sets() -> tuple[str, ...]:
    """Names of the strength sets that ship with the package, in alphabetical order."""
    return tuple(sorted(path.stem for path in STRENGTHS.glob("*.yaml")))


def load_strengths(name: str) -> StrengthSet:
    """A strength set: one that ships with the package, by name, or a user's own, by path.

    `NAME:p5` is the set NAME, taken for the mean of normal distributions, at the 5th percentile of every entry (see
    `strength_spread`). Raises DataFileError for a set, a percentile or a degree of freedom that is unknown, an
    incomplete or unreadable file, and files that are based on each other.
    """
    at = _AT_PERCENTILE.fullmatch(name)
    if at is None:
        return _load(_find(name, Path(), "strength set"), ())
    percentile = float(at[2])
    if not LOWEST_PERCENTILE <= percentile <= HIGHEST_PERCENTILE:
        raise DataFileError(f"strength set {name!r}: the percentile should be from 1 to 99.")
    return _at_percentile(load_strengths(at[1]), percentile)


def at_percentile(name: str, percentile: float) -> str:
    """The name of a set at a percentile of strength; the 50th is the set itself."""
    return name if percentile == 50 else f"{name}:p{round(percentile, 2):g}"


class Spreads(Settings):
    """Content of data/strength_spread.yaml: standard deviation / mean by degree of freedom, without side."""

    assumed: float
    degrees_of_freedom: dict[str, dict[Direction, float]]


@cache
def _spreads() -> Spreads:
    return load_data(DATA / "strength_spread.yaml", Spreads)


def strength_spread(entry: Entry) -> float:
    """By how much people differ at an entry: standard deviation / mean of its maximum torque."""
    freedom, direction = entry
    known = _spreads().degrees_of_freedom.get(without_side(freedom))
    return known[direction] if known else _spreads().assumed


def _at_percentile(mean: StrengthSet, percentile: float) -> StrengthSet:
    z = NormalDist().inv_cdf(percentile / 100)
    text = f"percentile {percentile:g}"
    entries = {
        entry: StrengthEntry(at.torque_nm * (1 + strength_spread(entry) * z), f"computed: {text}; {at.source}")
        for entry, at in mean.entries.items()
    }
    return StrengthSet(f"{mean.population}, {text} in every entry", mean.based_on, entries)


def _find(name: str, folder: Path, what: str) -> Path:
    """The file of a set; a path is relative to `folder`; `what` begins the message if there is none."""
    if name in shipped_sets():
        return STRENGTHS / f"{name}.yaml"
    path = folder / name
    try:
        found = path.exists()
    except OSError:  # the system takes no such name
        found = False
    if not found:
        shipped = ", ".join(shipped_sets())
        raise DataFileError(f"{what} {name!r}: neither one of {shipped} nor a file ({path.absolute()}).")
    return path


@cache
def _shipped(path: Path) -> StrengthFile:
    return load_data(path, StrengthFile)


def _load(path: Path, above: tuple[Path, ...]) -> StrengthSet:
    """The set of a file on which the last of the files `above` is based, that one on the one before it, …."""
    this = path.resolve()
    if this in above:
        circle = " -> ".join(file.name for file in (*above[above.index(this) :], this))
        raise DataFileError(f"{path}: based_on goes round in a circle: {circle}.")
    if len(above) >= MAX_CHAIN_LENGTH:
        raise DataFileError(f"{path}: based_on: more than {MAX_CHAIN_LENGTH} files build on each other.")
    content = _shipped(path) if path.parent == STRENGTHS else load_data(path, StrengthFile)
    entries: dict[Entry, StrengthEntry] = {}
    if content.based_on is not None:
        entries |= _load(_find(content.based_on, path.parent, f"{path}: based_on"), (*above, this)).entries
    for freedom in DEGREES_OF_FREEDOM:
        for name in (without_side(freedom), freedom):
            if name in content.degrees_of_freedom:
                entries |= _entries(freedom, content.degrees_of_freedom[name])
    _check_complete(path, content, entries)
    return StrengthSet(content.population, content.based_on, entries)


def _entries(freedom: str, row: Strength) -> dict[Entry, StrengthEntry]:
    both: dict[Direction, float | None] = {"positive": row.positive, "negative": row.negative}
    return {(freedom, way): StrengthEntry(torque, row.source) for way, torque in both.items() if torque is not None}


def _check_complete(path: Path, content: StrengthFile, entries: dict[Entry, StrengthEntry]) -> None:
    """Raise DataFileError if the file names what the skeleton has not, or something has no torque."""
    unknown = content.degrees_of_freedom.keys() - {
        name for freedom in DEGREES_OF_FREEDOM for name in (freedom, without_side(freedom))
    }
    missing = set()
    for freedom in DEGREES_OF_FREEDOM:
        ways = [way for way in ("positive", "negative") if (freedom, way) not in entries]
        missing |= {without_side(freedom)} if len(ways) == 2 else {f"{without_side(freedom)}:{way}" for way in ways}
    if unknown or missing:
        remedy = "" if not missing or unknown else " Or name a set as `based_on`."
        raise DataFileError(
            f"{path}: degrees of freedom missing: {sorted(missing) or 'none'}, "
            f"unknown: {sorted(unknown) or 'none'}.{remedy}"
        )

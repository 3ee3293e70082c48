"""The kinds of factors of a study.

A factor is a choice that could have been made otherwise. It has levels (numbers or names), each of which
changes some settings of an experiment. A position in [0, 1] corresponds to a level, so that a point in the unit cube
corresponds to a combination of all factors.
"""

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.core.errors import ExperimentError, listed, shortened
from fatigue_planner.core.settings import Name, Settings

Level = float | str
Matrix = NDArray[np.float64]

# The experiment's own values of the keys that a factor changes, by dotted key.
BaseValues = Mapping[str, Any]


def level_text(level: Level) -> str:
    """A level as text: a number with as many digits as it needs."""
    return level if isinstance(level, str) else f"{level:.6g}"


def listed_values(values: BaseValues) -> str:
    """The experiment's own values as a message shows them."""
    return listed(f"{key} = {shortened(value)}" for key, value in values.items())


class FactorSettings(Settings):
    """A factor of a study."""

    kind: str
    reason: str = Field(min_length=1, description="Why these levels, for the page of results.")

    @abstractmethod
    def changed_keys(self) -> tuple[str, ...]:
        """The dotted keys of the settings it changes."""

    @abstractmethod
    def base_level(self, base: BaseValues) -> Level:
        """The level that is the experiment's own. Raises ExperimentError if there is none."""

    @abstractmethod
    def level_at(self, position: float) -> Level:
        """The level at a position in [0, 1]."""

    @abstractmethod
    def all_levels(self) -> Sequence[Level]:
        """The levels tried one at a time."""

    @abstractmethod
    def changes(self, level: Level, base: BaseValues) -> Mapping[str, Any]:
        """The values of the keys at a level."""

    @abstractmethod
    def regressors(self, levels: Sequence[Level]) -> Matrix:
        """Columns (points, p), besides a constant, that describe the effect of levels (points,)."""

    def argument(self, level: Level) -> str:
        """Why a level could be chosen."""
        return self.reason


class NamedLevels(FactorSettings):
    """The base class of factors whose levels have names."""

    def level_at(self, position: float) -> Level:
        """The levels in their order, each for an equal part of [0, 1]."""
        names = self.all_levels()
        return names[min(int(position * len(names)), len(names) - 1)]

    def regressors(self, levels: Sequence[Level]) -> Matrix:
        """A column of zeros and ones for each level that occurs, except the first, which the constant represents."""
        names = [name for name in self.all_levels() if name in levels]
        return np.array([[level == name for name in names[1:]] for level in levels], dtype=float)


class ChoiceSettings(NamedLevels):
    """Levels by name; all set the same keys, and one of them has the experiment's own values."""

    kind: Literal["choice"] = Field(description="Named levels, each with values of its own.")
    levels: dict[str, dict[str, Any]] = Field(
        min_length=2,
        max_length=20,
        description="Levels by name: the same dotted keys of the experiment in each, with their values. One level is "
        "the experiment's own.",
    )

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        keys = set(self.changed_keys())
        for name, values in self.levels.items():
            if set(values) != keys:
                raise ValueError(f"levels.{name}: all levels must give the same keys; {listed(sorted(keys))}")
        if not keys:
            raise ValueError("levels: give no key a value")
        return self

    def changed_keys(self) -> tuple[str, ...]:
        """The keys of the first level, which are those of all."""
        return tuple(next(iter(self.levels.values())))

    def base_level(self, base: BaseValues) -> Level:
        """The level that changes nothing."""
        for name, values in self.levels.items():
            if all(base[key] == value for key, value in values.items()):
                return name
        own = listed_values({key: base[key] for key in self.changed_keys()})
        raise ExperimentError(f"levels: none is the experiment's own ({own}).")

    def all_levels(self) -> Sequence[Level]:
        """Every name."""
        return list(self.levels)

    def changes(self, level: Level, base: BaseValues) -> Mapping[str, Any]:
        """The values of the level."""
        return self.levels[str(level)]


class Reading(Settings):
    """Another reading of a text: what it changes, and the argument for it."""

    argument: str = Field(min_length=1, description="The argument for this reading, for the page of results.")
    changes: dict[str, Any] = Field(
        min_length=1, max_length=100, description="What it changes: dotted keys of the experiment and their values."
    )


class ReadingsSettings(NamedLevels):
    """The experiment as it is, which is one reading of a text, and other readings, each with an argument."""

    kind: Literal["readings"] = Field(description="Readings of a text, each with its argument and its changes.")
    base: Name = Field(description="Name of the experiment's own reading; `reason` is the argument for it.")
    others: dict[Name, Reading] = Field(min_length=1, max_length=20, description="The other readings, by name.")

    @model_validator(mode="after")
    def _check_base(self) -> Self:
        if self.base in self.others:
            raise ValueError(f"base = {self.base!r}: is also among the others")
        return self

    def changed_keys(self) -> tuple[str, ...]:
        """The keys that some reading changes."""
        return tuple(dict.fromkeys(key for reading in self.others.values() for key in reading.changes))

    def base_level(self, base: BaseValues) -> Level:
        """The experiment's own reading."""
        return self.base

    def all_levels(self) -> Sequence[Level]:
        """Every name, the experiment's own first."""
        return [self.base, *self.others]

    def changes(self, level: Level, base: BaseValues) -> Mapping[str, Any]:
        """The changes of the reading."""
        return {} if level == self.base else self.others[str(level)].changes

    def argument(self, level: Level) -> str:
        """The argument for the reading."""
        return self.reason if level == self.base else self.others[str(level)].argument


# How many levels are tried one at a time: both ends and two between them.
LEVELS = 4
# How many significant digits a level has.
DIGITS = 4
# Limits of levels: their quotients and differences neither overflow nor underflow.
MAX_LEVEL, MIN_LOG_LEVEL = 1e12, 1e-12


class SpanSettings(FactorSettings):
    """The base class of factors whose levels are numbers."""

    keys: tuple[str, ...] = Field(
        min_length=1, max_length=1000, description="Dotted keys of the experiment's settings that the factor changes."
    )
    first: float = Field(
        alias="from",
        ge=-MAX_LEVEL,
        le=MAX_LEVEL,
        description="Lowest level, in the keys' unit; of a scale, without unit.",
    )
    last: float = Field(
        alias="to",
        ge=-MAX_LEVEL,
        le=MAX_LEVEL,
        description="Highest level, in the keys' unit; of a scale, without unit.",
    )
    scale: Literal["linear", "log"] = Field(
        default="linear", description="Whether the levels or their logarithms are evenly spaced."
    )

    @model_validator(mode="after")
    def _check_span(self) -> Self:
        if self.first >= self.last:
            raise ValueError(f"from = {self.first:g} must be below to = {self.last:g}")
        if self.scale == "log" and self.first < MIN_LOG_LEVEL:
            raise ValueError(f"from = {self.first:g} must be above 0 on a log scale, {MIN_LOG_LEVEL:g} at least")
        return self

    def changed_keys(self) -> tuple[str, ...]:
        """The keys that the factor changes."""
        return self.keys

    def level_at(self, position: float) -> Level:
        """from at 0, to at 1."""
        if self.scale == "log":
            value = self.first * (self.last / self.first) ** position
        else:
            value = self.first + (self.last - self.first) * position
        return float(f"{value:.{DIGITS}g}")

    def all_levels(self) -> Sequence[Level]:
        """Evenly spaced on the scale."""
        return [self.level_at(position) for position in np.linspace(0, 1, LEVELS).tolist()]

    def regressors(self, levels: Sequence[Level]) -> Matrix:
        """Position on the scale, from -1 to 1, and its square."""
        values = np.array(levels, dtype=float)
        first, last = self.first, self.last
        if self.scale == "log":
            values, first, last = np.log(values), math.log(first), math.log(last)
        position = 2 * (values - first) / (last - first) - 1
        return np.column_stack([position, position**2])


class RangeSettings(SpanSettings):
    """Every key gets the same value between `from` and `to`."""

    kind: Literal["range"] = Field(description="The same value for all keys.")
    integer: bool = Field(default=False, description="Whether levels are rounded to whole numbers.")

    def base_level(self, base: BaseValues) -> Level:
        """The value that all keys have in common."""
        values = {key: base[key] for key in self.keys}
        number = next(iter(values.values()))
        if any(isinstance(value, bool) or not isinstance(value, int | float) for value in values.values()):
            raise ExperimentError(f"keys: {listed_values(values)}: a range is for numbers; use kind: choice.")
        if len(set(values.values())) > 1:
            raise ExperimentError(f"keys: {listed_values(values)} are not the same in the experiment; use kind: scale.")
        if not self.first <= number <= self.last:
            raise ExperimentError(
                f"from = {self.first:g}, to = {self.last:g}: the experiment's own {listed_values(values)} is outside."
            )
        return float(number)

    def level_at(self, position: float) -> Level:
        """from at 0, to at 1; rounded to whole numbers if `integer`."""
        level = super().level_at(position)
        return float(round(float(level))) if self.integer else level

    def changes(self, level: Level, base: BaseValues) -> Mapping[str, Any]:
        """The level for every key."""
        return dict.fromkeys(self.keys, int(level) if self.integer else float(level))


class ScaleSettings(SpanSettings):
    """Every key's own value times the same number between `from` and `to`."""

    kind: Literal["scale"] = Field(description="A factor by which the keys' own values are multiplied.")

    def base_level(self, base: BaseValues) -> Level:
        """1: the values as they are."""
        for key in self.keys:
            if isinstance(base[key], bool) or not isinstance(base[key], int | float):
                raise ExperimentError(
                    f"keys: {key} = {shortened(base[key])}: only numbers can be multiplied; use kind: choice."
                )
        if not self.first <= 1 <= self.last:
            raise ExperimentError(f"from = {self.first:g}, to = {self.last:g}: 1, the experiment's own, is outside.")
        return 1.0

    def changes(self, level: Level, base: BaseValues) -> Mapping[str, Any]:
        """The level times each key's own value."""
        return {key: float(f"{float(level) * base[key]:.{DIGITS}g}") for key in self.keys}


AnyFactor = Annotated[RangeSettings | ScaleSettings | ChoiceSettings | ReadingsSettings, Field(discriminator="kind")]

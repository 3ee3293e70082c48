"""What every kind of factor can do.

A factor is a choice that could have been made otherwise. It has levels (numbers or names), each of which stands for
changes of an experiment's settings. A share from [0, 1] of the factor's span stands for a level, so that points of the
unit cube stand for combinations of all factors.
"""

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from fatigue_planner.core.errors import ExperimentError, shortened
from fatigue_planner.core.settings import Settings

Level = float | str
Matrix = NDArray[np.float64]

# What the experiment itself says of the keys a factor changes, by dotted key.
BaseValues = Mapping[str, Any]


def level_text(level: Level) -> str:
    """A level as it is written: a number with as many digits as it needs."""
    return level if isinstance(level, str) else f"{level:.6g}"


def listed_values(values: BaseValues) -> str:
    """The experiment's own values as a message shows them."""
    return ", ".join(f"{key} = {shortened(value)}" for key, value in values.items())


class FactorSettings(Settings):
    """A factor as it stands in a study."""

    kind: str
    reason: str = Field(min_length=1, description="Why these levels, for the page of results.")

    @abstractmethod
    def changed_keys(self) -> tuple[str, ...]:
        """The dotted keys of the settings it changes."""

    @abstractmethod
    def base_level(self, base: BaseValues) -> Level:
        """The level that is the experiment's own. Raises ExperimentError if there is none."""

    @abstractmethod
    def level_at(self, share: float) -> Level:
        """The level that a share in [0, 1] of the span stands for."""

    @abstractmethod
    def all_levels(self) -> Sequence[Level]:
        """The levels tried one at a time."""

    @abstractmethod
    def changes(self, level: Level, base: BaseValues) -> Mapping[str, Any]:
        """The values of the keys at a level."""

    @abstractmethod
    def regressors(self, levels: Sequence[Level]) -> Matrix:
        """Columns (points, p), besides a constant, by which the effect of levels (points,) is described."""


class ChoiceSettings(FactorSettings):
    """Levels by name; all give values to the same keys, and one of them gives the experiment's own."""

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
                raise ValueError(f"levels.{name}: all levels must give the same keys; {', '.join(sorted(keys))}")
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

    def level_at(self, share: float) -> Level:
        """The levels in their order, each for an equal part of [0, 1]."""
        names = list(self.levels)
        return names[min(int(share * len(names)), len(names) - 1)]

    def all_levels(self) -> Sequence[Level]:
        """Every name."""
        return list(self.levels)

    def changes(self, level: Level, base: BaseValues) -> Mapping[str, Any]:
        """What the level says."""
        return self.levels[str(level)]

    def regressors(self, levels: Sequence[Level]) -> Matrix:
        """One column of zeros and ones for each level that occurs but one, which the constant stands for."""
        names = [name for name in self.levels if name in levels]
        return np.array([[level == name for name in names[1:]] for level in levels], dtype=float)


# One at a time: both ends and two levels between them.
LEVELS = 4
# Levels are rounded to so many significant digits.
DIGITS = 4
# Quotients and differences of levels stay far from where numbers end.
LARGEST, SMALLEST = 1e12, 1e-12


class SpanSettings(FactorSettings):
    """What factors whose levels are numbers have in common."""

    keys: tuple[str, ...] = Field(
        min_length=1, max_length=1000, description="Dotted keys of the experiment's settings that the factor changes."
    )
    first: float = Field(
        alias="from", ge=-LARGEST, le=LARGEST, description="Lowest level, in the keys' unit; of a scale, without unit."
    )
    last: float = Field(
        alias="to", ge=-LARGEST, le=LARGEST, description="Highest level, in the keys' unit; of a scale, without unit."
    )
    scale: Literal["linear", "log"] = Field(
        default="linear", description="Whether levels are evenly spaced themselves or in their logarithm."
    )

    @model_validator(mode="after")
    def _check_span(self) -> Self:
        if self.first >= self.last:
            raise ValueError(f"from = {self.first:g} must be below to = {self.last:g}")
        if self.scale == "log" and self.first < SMALLEST:
            raise ValueError(f"from = {self.first:g} must be above 0 on a log scale, {SMALLEST:g} at least")
        return self

    def changed_keys(self) -> tuple[str, ...]:
        """The keys, all of which get the same level."""
        return self.keys

    def level_at(self, share: float) -> Level:
        """from at 0, to at 1."""
        if self.scale == "log":
            value = self.first * (self.last / self.first) ** share
        else:
            value = self.first + (self.last - self.first) * share
        return float(f"{value:.{DIGITS}g}")

    def all_levels(self) -> Sequence[Level]:
        """Evenly spaced on the scale."""
        return [self.level_at(share) for share in np.linspace(0, 1, LEVELS).tolist()]

    def regressors(self, levels: Sequence[Level]) -> Matrix:
        """Place on the scale, from -1 to 1, and its square."""
        values = np.array(levels, dtype=float)
        first, last = self.first, self.last
        if self.scale == "log":
            values, first, last = np.log(values), math.log(first), math.log(last)
        place = 2 * (values - first) / (last - first) - 1
        return np.column_stack([place, place**2])


class RangeSettings(SpanSettings):
    """Every key gets the same value between `from` and `to`."""

    kind: Literal["range"] = Field(description="The same value for all keys.")
    integer: bool = Field(default=False, description="Whether levels are rounded to whole numbers.")

    def base_level(self, base: BaseValues) -> Level:
        """The one value that all keys have."""
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

    def level_at(self, share: float) -> Level:
        """from at 0, to at 1; whole numbers where only these make sense."""
        level = super().level_at(share)
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


AnyFactor = Annotated[RangeSettings | ScaleSettings | ChoiceSettings, Field(discriminator="kind")]

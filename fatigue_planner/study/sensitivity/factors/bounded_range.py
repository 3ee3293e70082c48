"""Numbers between two ends, evenly spread on a linear or logarithmic scale."""

import math
from collections.abc import Sequence
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from fatigue_planner.study.sensitivity.factors.factor import FactorSettings, Level, Matrix

# One at a time: both ends and two levels between them.
LEVELS = 4
# Levels are rounded to so many significant digits.
DIGITS = 4
# Quotients and differences of levels stay far from where numbers end.
LARGEST, SMALLEST = 1e12, 1e-12


class SpanSettings(FactorSettings):
    """What factors whose levels are numbers have in common."""

    keys: tuple[str, ...] = Field(min_length=1, max_length=1000)
    first: float = Field(alias="from", ge=-LARGEST, le=LARGEST)
    last: float = Field(alias="to", ge=-LARGEST, le=LARGEST)
    scale: Literal["linear", "log"] = "linear"

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

"""A factor with named levels, each of which gives values to some keys."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.study.sensitivity.factors.factor import BaseValues, FactorSettings, Level, Matrix, listed_values


class ChoiceSettings(FactorSettings):
    """Levels by name; all give values to the same keys, and one of them gives the experiment's own."""

    kind: Literal["choice"]
    levels: dict[str, dict[str, Any]] = Field(min_length=2, max_length=20)

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

"""A factor that multiplies numbers: the level is by how much."""

from collections.abc import Mapping
from typing import Any, Literal

from fatigue_planner.core.errors import ExperimentError, shortened
from fatigue_planner.study.sensitivity.factors.bounded_range import DIGITS, SpanSettings
from fatigue_planner.study.sensitivity.factors.factor import BaseValues, Level


class ScaleSettings(SpanSettings):
    """Every key's own value times the same number between `from` and `to`."""

    kind: Literal["scale"]

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

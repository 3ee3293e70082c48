"""A factor that sets numbers: the level is the value."""

from collections.abc import Mapping
from typing import Any, Literal

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.study.sensitivity.factors.bounded_range import SpanSettings
from fatigue_planner.study.sensitivity.factors.factor import BaseValues, Level, listed_values


class RangeSettings(SpanSettings):
    """Every key gets the same value between `from` and `to`."""

    kind: Literal["range"]
    integer: bool = False

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

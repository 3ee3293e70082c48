"""What every kind of factor can do.

A factor is a choice that could have been made otherwise. It has levels (numbers or names), each of which stands for
changes of an experiment's settings. A share from [0, 1] of the factor's span stands for a level, so that points of the
unit cube stand for combinations of all factors.
"""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.errors import shortened
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
    """A factor as it stands in a study; `reason`: why these levels, for the page of results."""

    kind: str
    reason: str = Field(min_length=1)

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

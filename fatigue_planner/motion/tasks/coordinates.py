"""A place of which some coordinates may be free."""

from typing import Self

import numpy as np
from pydantic import Field, model_validator

from fatigue_planner.core.settings import Settings
from fatigue_planner.motion.tasks.task import Vector


class Coordinates(Settings):
    """World coordinates in m (x forward, y left, z up, from the centre between the soles); those left out are free."""

    x: float | None = Field(default=None, ge=-3, le=3)
    y: float | None = Field(default=None, ge=-3, le=3)
    z: float | None = Field(default=None, ge=0, le=3)

    @model_validator(mode="after")
    def _check_some(self) -> Self:
        if not self.axes():
            raise ValueError("give at least one of x, y and z")
        return self

    def axes(self) -> list[int]:
        """The places of the coordinates given."""
        return [i for i, value in enumerate((self.x, self.y, self.z)) if value is not None]

    def values(self) -> Vector:
        """The coordinates given, (n,) m."""
        return np.array([value for value in (self.x, self.y, self.z) if value is not None])

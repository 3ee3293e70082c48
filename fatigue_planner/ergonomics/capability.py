"""The share of people who can do something: a normal distribution about a mean, and the common levels of that share."""

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.result import Level

Vector = NDArray[np.float64]

# Three quarters of a population is the usual criterion (Snook 1978; NIOSH 1981 and the UAW-GM programme for women). A
# quarter is the strength limit of NIOSH's 1981 guide for men, above which work is not allowed (recalled).
ENOUGH, TOO_FEW = 75.0, 25.0


def capable_percent(load: ArrayLike, mean: ArrayLike, variation: ArrayLike) -> Vector:
    """The share in % of people whose strength, normal with a mean and a coefficient of variation, reaches a load."""
    return np.asarray(100 * ndtr((1 - np.asarray(load) / np.asarray(mean)) / np.asarray(variation)))


class CapableShare(Indicator):
    """Methods whose value is a share of people in %: the smaller, the worse."""

    words: ClassVar[tuple[str, str, str]] = (
        "enough people can do it",
        "fewer than three quarters can do it",
        "fewer than a quarter can do it",
    )

    @staticmethod
    def level_of(percent: float) -> Level:
        """The level of a share in %."""
        if percent < TOO_FEW:
            return Level.NOT_ACCEPTABLE
        return Level.INVESTIGATE if percent < ENOUGH else Level.ACCEPTABLE

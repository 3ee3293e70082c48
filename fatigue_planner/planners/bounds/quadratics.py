"""Separable quadratics of a state, as plain arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Quadratics:
    """Functions value + sum over the entries of slope d + curvature d^2 of a displacement d (L,).

    value (...,); slope, curvature (..., L), or of a shape that broadcasts to it.
    """

    value: Array
    slope: Array
    curvature: Array

    def __getitem__(self, index: Any) -> "Quadratics":
        """Some of the functions; `index` counts the axes of `value`."""
        return Quadratics(self.value[index], self.slope[index], self.curvature[index])

    def __sub__(self, other: "Quadratics") -> "Quadratics":
        """The difference of functions of the same displacement."""
        return Quadratics(self.value - other.value, self.slope - other.slope, self.curvature - other.curvature)

    def reshape(self, *shape: int) -> "Quadratics":
        """The same functions with `value` in another shape."""
        length = self.slope.shape[-1]
        return Quadratics(
            self.value.reshape(shape), self.slope.reshape(*shape, length), self.curvature.reshape(*shape, length)
        )

    def at(self, displacement: Array) -> Array:
        """The values (...,) at displacements (..., L)."""
        return np.asarray(self.value + ((self.slope + self.curvature * displacement) * displacement).sum(axis=-1))

    def mean(self, weights: Array) -> "Quadratics":
        """Mean with weights (..., F), whose sum is 1, over the last axis of `value`, F."""
        return Quadratics(
            (weights * self.value).sum(axis=-1),
            np.einsum("...f,...fl->...l", weights, self.slope),
            np.einsum("...f,...fl->...l", weights, self.curvature),
        )

    def minimum(self, low: Array, high: Array) -> Array:
        """The least value (...,) over the box low <= d <= high, both (..., L), low <= 0 <= high.

        Entry by entry: a convex one is least where its derivative vanishes or at the end nearest to there,
        any other one at an end.
        """
        convex = self.curvature > 0
        stationary = np.divide(-0.5 * self.slope, self.curvature, where=convex, out=np.zeros_like(self.slope))
        end = np.where(self.slope + self.curvature * (low + high) > 0, low, high)
        return self.at(np.where(convex, np.clip(stationary, low, high), end))


def zero(size: int, length: int) -> Quadratics:
    """Functions (size,) that vanish everywhere."""
    return Quadratics(np.zeros(size), np.zeros((size, length)), np.zeros((size, length)))


def joined(parts: Sequence[Quadratics]) -> Quadratics:
    """The functions of all parts, in this order."""
    return Quadratics(
        np.concatenate([part.value for part in parts]),
        np.concatenate([part.slope for part in parts]),
        np.concatenate([part.curvature for part in parts]),
    )

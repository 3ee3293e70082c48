"""What fatigue costs: the paper's mean square (Eq. 5), weighted or not, or the most tired joint; and its kernels."""

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.jit import inlined, kernel
from fatigue_planner.pomdp.simd import move, sum_of_squares_after

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

CostKind = Literal["mean_square", "worst_joint"]


@dataclass(frozen=True)
class FatigueCost:
    """C(f) of a fatigue f (2N,): mean_square, the sum of w f^2 / 2N; worst_joint, the largest w f.

    weights (2N,): w, without unit; 1 for all in the paper. What a reaction's posture costs is added to either.
    """

    kind: CostKind
    weights: Vector

    @property
    def is_quadratic(self) -> bool:
        """Whether it is a quadratic of every entry, which bounds and the values of cyclic plans need."""
        return self.kind == "mean_square"

    def check_quadratic(self, what: str) -> None:
        """Raise ExperimentError, naming the cost, if `what` cannot work with it."""
        if not self.is_quadratic:
            raise ExperimentError(f"{what}: {not_quadratic(self.kind)}.")

    def of(self, fatigue: Array) -> Array:
        """The cost (...,) of fatigues (..., 2N)."""
        if self.is_quadratic:
            return np.asarray(np.mean(self.weights * fatigue**2, axis=-1))
        return np.asarray((self.weights * fatigue).max(axis=-1))


def not_quadratic(kind: CostKind) -> str:
    """Why a cost of a kind is of no use where a quadratic is needed."""
    return f"needs a cost that is quadratic in fatigue; cost.fatigue is {kind}, mean_square would do"


def mean_square(entries: int) -> FatigueCost:
    """The paper's cost (Eq. 5)."""
    return FatigueCost("mean_square", np.ones(entries))


class CostArrays(NamedTuple):
    """What the kernels below read of `FatigueArrays`.

    weight (W,): of the active entries; scale: 1 / 2N; posture (rows,): what the posture of each cycle adds;
    plain: the paper's cost, with weights 1 and no posture; worst: the most tired joint counts
    """

    weight: Vector
    scale: float
    posture: Vector
    plain: bool
    worst: bool


@inlined
def cost_after(cost: CostArrays, gain: Array, offset: Array, state: Vector, row: int) -> float:
    """The cost after the cycle of a row of the maps; the state stays as it is."""
    if cost.plain:
        return float(cost.scale * sum_of_squares_after(gain, offset, state, row))
    return float(other_cost_after(cost, gain, offset, state, row))


@inlined
def cost_moving(cost: CostArrays, gain: Array, offset: Array, state: Vector, row: int) -> float:
    """Apply the cycle of a row of the maps to the state; its cost."""
    if cost.plain:
        return float(cost.scale * move(gain, offset, state, row))
    found = other_cost_after(cost, gain, offset, state, row)
    move(gain, offset, state, row)
    return float(found)


@kernel
def other_cost_after(cost: Any, gain: Array, offset: Array, state: Vector, row: int) -> float:
    """The cost after a cycle, whatever its kind."""
    total, largest = 0.0, 0.0
    for j in range(cost.weight.size):
        fatigue = gain[row, j] * state[j] + offset[row, j]
        total += cost.weight[j] * fatigue * fatigue
        largest = max(largest, cost.weight[j] * fatigue)
    return float((largest if cost.worst else cost.scale * total) + cost.posture[row])

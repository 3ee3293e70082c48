"""The parameters and the working memory of a search."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.pomdp.simd import aligned_zeros

Vector = NDArray[np.float64]

# Stands for 0 where it may be multiplied by infinity.
TINY = 1e-150


class SearchParameters(NamedTuple):
    """The parameters of a search, with tables indexed by a count n (see `tables`)."""

    exploration_constant: float
    discount: float
    rollout_cycles: int
    root_log: Vector
    inverse_root: Vector
    inverse: Vector


@lru_cache(maxsize=4)
def tables(size: int) -> tuple[Vector, Vector, Vector]:
    """sqrt(log n), 1 / sqrt(n) and 1 / n for n < size.

    1 / sqrt(0) = inf lets the first action not tried win; sqrt(log 0) and sqrt(log 1) are TINY, as 0 times
    infinity would be NaN.
    """
    n = np.arange(size, dtype=float)
    root_log = np.sqrt(np.log(np.maximum(n, 1)))
    root_log[:2] = TINY
    with np.errstate(divide="ignore"):
        return root_log, 1 / np.sqrt(n), 1 / n


class Workspace(NamedTuple):
    """Working memory: two states (L,), outcome probabilities (K,), and the path of a descent by depth.

    rows: those of the maps, of steps that are known already (`recall`).
    """

    state: Vector
    moved: Vector
    probabilities: Vector
    nodes: NDArray[np.uint32]
    actions: NDArray[np.uint32]
    rewards: Vector
    rows: NDArray[np.int64]


def new_workspace(width: int, outcomes: int, capacity: int) -> Workspace:
    """Memory for states of `width` parameters and a tree of `capacity` nodes."""
    path = np.empty(capacity, np.uint32)
    return Workspace(
        aligned_zeros(width),
        aligned_zeros(width),
        np.zeros(outcomes),
        path,
        path.copy(),
        np.empty(capacity),
        np.empty(capacity, np.int64),
    )

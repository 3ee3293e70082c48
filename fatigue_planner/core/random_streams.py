"""Random streams, each keyed by what it is for.

Common random numbers: what is drawn for a trial depends on seed, condition, length and trial, never on the policy.
All policies of a trial meet the same worker, so their returns can be compared pairwise. The planner
draws from a stream of its own, so it cannot see the world's future.
"""

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.files import canonical_json

Vector = NDArray[np.float64]


def random_stream(seed: int, *key: str | int) -> np.random.Generator:
    """The generator of a purpose: equal keys give equal draws on every machine and in any order."""
    digest = hashlib.sha256(canonical_json([seed, *key]).encode()).digest()
    return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest)))


@dataclass(frozen=True)
class RandomNumbers:
    """Uniform draws in [0, 1) for the worker (3,), the start and every cycle."""

    worker: Vector
    start: float
    preference: Vector
    observation: Vector


def draw_random_numbers(seed: int, condition: str, n_cycles: int, trial: int) -> RandomNumbers:
    """The common random numbers of a trial, the same for every policy."""
    key = (condition, n_cycles, trial)
    return RandomNumbers(
        random_stream(seed, "worker", *key).random(3),
        float(random_stream(seed, "start", *key).random()),
        random_stream(seed, "preference", *key).random(n_cycles),
        random_stream(seed, "observation", *key).random(n_cycles),
    )

"""Random streams, each keyed by what it is for.

Common random numbers: what is drawn for a trial depends on seed, condition, length and trial, never on the policy.
All policies of a trial meet the same worker, so their returns can be compared pairwise. The planner
draws from a stream of its own, so it cannot see the world's future.
"""

import hashlib
from dataclasses import dataclass, fields

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


def world_stream(what: str, seed: int, condition: str, n_cycles: int, trial: int) -> np.random.Generator:
    """The stream of one of the common random numbers of a trial: a field of `RandomNumbers`."""
    key = (condition, n_cycles, trial)
    return random_stream(seed, what, *key)


def draw_random_numbers(seed: int, condition: str, n_cycles: int, trial: int) -> RandomNumbers:
    """The common random numbers of a trial, the same for every policy."""
    worker, start, preference, observation = (
        world_stream(field.name, seed, condition, n_cycles, trial) for field in fields(RandomNumbers)
    )
    return RandomNumbers(
        worker.random(3), float(start.random()), preference.random(n_cycles), observation.random(n_cycles)
    )

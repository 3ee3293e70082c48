"""Random streams, each keyed by what it is for.

The world's draws depend on seed, condition, length and trial, never on the policy: all policies of a
trial meet the same worker, so their returns can be compared pairwise. The planner draws from a stream of its own, so
it cannot see the world's future.
"""

import hashlib

import numpy as np

from fatigue_planner.core.files import canonical_json


def stream(seed: int, *key: str | int) -> np.random.Generator:
    """The generator of a purpose: equal keys give equal draws on every machine and in any order."""
    digest = hashlib.sha256(canonical_json([seed, *key]).encode()).digest()
    return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest)))

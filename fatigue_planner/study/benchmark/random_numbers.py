"""The chance of one run, drawn before it begins: all policies of a trial meet the same world."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.random_streams import stream

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class World:
    """Uniform draws in [0, 1) for the worker (3,), the start and every cycle."""

    worker: Vector
    start: float
    preference: Vector
    observation: Vector


def draw_world(seed: int, condition: str, n_cycles: int, trial: int) -> World:
    """The world of a trial, the same for every policy."""
    key = (condition, n_cycles, trial)
    return World(
        stream(seed, "worker", *key).random(3),
        float(stream(seed, "start", *key).random()),
        stream(seed, "preference", *key).random(n_cycles),
        stream(seed, "observation", *key).random(n_cycles),
    )

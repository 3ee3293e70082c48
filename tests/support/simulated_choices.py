"""Simulated workers' cycles to learn from, with known truth."""

import math

import numpy as np

from fatigue_planner.recordings.learning.estimate import Estimator
from fatigue_planner.recordings.learning.likelihood import Choices, Confusion

ERRS = np.array([[[0.9, 0.1], [0.15, 0.85]]])


def simulated(seed: int, cycles: int = 200, beta: float = 1.0, offset: float = 0.4, inertia: float = 0.0) -> Estimator:
    """Utilities differ by 0.5 to 2.5, either way; 10 and 15 % confused, known from 140 repetitions of each."""
    rng = np.random.default_rng(seed)
    costs = np.zeros((cycles, 2))
    costs[:, 1] = rng.uniform(0.5, 2.5, cycles) * rng.choice([-1, 1], cycles)
    seen, last = np.zeros(cycles, np.int64), -1
    for t in range(cycles):
        odds = offset - beta * costs[t, 1] + inertia * ((last == 1) - (last == 0))
        last = int(rng.random() < 1 / (1 + math.exp(-odds)))
        seen[t] = rng.random() < ERRS[0, last, 1]
    labelled = np.array([[rng.multinomial(140, row) for row in ERRS[0]]], float)
    choices = Choices(costs, seen, np.zeros(cycles, np.int64), np.arange(cycles) == 0)
    return Estimator(choices, Confusion.from_counts(labelled))

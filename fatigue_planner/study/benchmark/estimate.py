"""How long a grid will take, before it is run."""

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.runner import TrialStore

# So many cells are timed, each for so many cycles, or for so many whole trials where these run together.
TIMED_CELLS = 200
TIMED_CYCLES = 3
TIMED_TRIALS = 20
MINUTES_FROM_S = 120


def decisions_left(grid: Sequence[Cell], store_folder: Path) -> list[int]:
    """By cell, the decisions of the trials that are not in the store yet."""
    store = TrialStore(store_folder)
    return [cell.n_cycles * len(set(cell.trial_numbers()) - store.load(cell).keys()) for cell in grid]


def estimated_seconds(grid: Sequence[Cell], left: Sequence[int], jobs: int) -> float:
    """About how long the decisions left take: each as long as the mean of a few timed now, which takes seconds.

    The cells timed are drawn with probabilities proportional to their decisions, so the estimate is not biased.
    """
    decisions = np.array(left, dtype=float)
    if not decisions.any():
        return 0.0
    draw = random_stream(0, "time estimate")
    chosen = draw.choice(len(grid), size=min(TIMED_CELLS, len(grid)), p=decisions / decisions.sum())
    return float(np.mean([_seconds_per_decision(grid[index]) for index in chosen]) * decisions.sum() / jobs)


def duration_text(seconds: float) -> str:
    """A duration in words."""
    return f"{seconds:.0f} s" if seconds < MINUTES_FROM_S else f"{seconds / 60:.0f} minutes"


def _seconds_per_decision(cell: Cell) -> float:
    many = cell.trials_at_once > 1
    brief, trials = (cell, range(TIMED_TRIALS)) if many else (replace(cell, n_cycles=TIMED_CYCLES), range(1))
    brief.run(trials)  # loads the compiled code
    begin = time.perf_counter()
    brief.run(trials)
    return (time.perf_counter() - begin) / (brief.n_cycles * len(trials))

"""The runs of all points in one grid: in parallel, resumed, and what two points have in common run once."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from fatigue_planner.benchmark.grid import Cell
from fatigue_planner.benchmark.job import Job
from fatigue_planner.benchmark.runner import run_grid
from fatigue_planner.benchmark.table import ACTIONS, TIMES, trial_table
from fatigue_planner.benchmark.trial import TrialResult
from fatigue_planner.experiment.selection import cells
from fatigue_planner.sensitivity.reactions import Reacted
from fatigue_planner.streams import stream

# For the estimate of time: so many cells are timed, each for so many cycles.
TIMED_CELLS = 200
TIMED_CYCLES = 3


class StudyGrid:
    """The cells of all points that can be performed.

    cells: every different cell once; of_point: by point, in the grid's order, the places of its cells among them.
    """

    def __init__(self, reacted: Sequence[Reacted]) -> None:
        places: dict[str, int] = {}
        self.cells: list[Cell] = []
        self.of_point: dict[str, list[int]] = {}
        for one in reacted:
            if one.point.experiment is None or one.profiles is None:
                continue
            own = cells(one.point.experiment, one.profiles)
            for cell in own:
                digest = cell.digest()
                if digest not in places:
                    places[digest] = len(self.cells)
                    self.cells.append(cell)
                self.of_point.setdefault(one.point.name, []).append(places[digest])

    def run(
        self, store: Path, jobs: int, progress: Callable[[Job[TrialResult], int], None]
    ) -> tuple[Mapping[str, pd.DataFrame], list[str]]:
        """The trials of every point, as `benchmark.table.trial_table` without times, and warnings about damaged files.

        Raises as `benchmark.runner.run_grid`, whose `progress` this is.
        """
        results, warnings = run_grid(self.cells, store, jobs, progress)
        tables = {
            point: trial_table([self.cells[place] for place in places], [results[place] for place in places])
            for point, places in self.of_point.items()
        }
        return {point: table.drop(columns=[ACTIONS, *TIMES]) for point, table in tables.items()}, warnings


def decisions_of(cell: Cell) -> int:
    """Decisions to take in all trials of a cell."""
    return len(cell.trial_numbers()) * cell.n_cycles


def estimated_seconds(grid: StudyGrid, jobs: int) -> float:
    """About how long all runs take: their decisions, each as long as the mean of a few timed now, which takes seconds.

    The cells timed are drawn with probabilities proportional to their decisions, so the estimate is not biased.
    """
    decisions = np.array([decisions_of(cell) for cell in grid.cells], dtype=float)
    draw = stream(0, "time estimate")
    chosen = draw.choice(len(grid.cells), size=min(TIMED_CELLS, len(grid.cells)), p=decisions / decisions.sum())
    return float(np.mean([_seconds_per_decision(grid.cells[place]) for place in chosen]) * decisions.sum() / jobs)


def _seconds_per_decision(cell: Cell) -> float:
    brief = replace(cell, n_cycles=TIMED_CYCLES)
    brief.run([0])  # loads the compiled code
    begin = time.perf_counter()
    brief.run([0])
    return (time.perf_counter() - begin) / TIMED_CYCLES

"""The runs of all points in one grid: in parallel, resumed, and what two points have in common run once."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pandas as pd

from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.job import Job
from fatigue_planner.study.benchmark.runner import run_grid
from fatigue_planner.study.benchmark.selection import cells
from fatigue_planner.study.benchmark.tables import ACTIONS, TIMES, trial_table
from fatigue_planner.study.benchmark.trial import TrialResult
from fatigue_planner.study.sensitivity.reactions import Reacted


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
        self, store: Path, executor: Executor, progress: Callable[[Job[TrialResult], int], None]
    ) -> tuple[Mapping[str, pd.DataFrame], list[str]]:
        """The trials of every point, as `benchmark.table.trial_table` without times, and warnings about damaged files.

        Raises as `benchmark.runner.run_grid`, whose `progress` this is.
        """
        results, warnings = run_grid(self.cells, store, executor, progress)
        tables = {
            point: trial_table([self.cells[place] for place in places], [results[place] for place in places])
            for point, places in self.of_point.items()
        }
        return {point: table.drop(columns=[ACTIONS, *TIMES]) for point, table in tables.items()}, warnings

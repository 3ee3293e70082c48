"""The runs of all points in a single grid, with cells that points share run once."""

from collections.abc import Mapping, Sequence

import pandas as pd

from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.selection import cells
from fatigue_planner.study.benchmark.tables import ACTIONS, TIMES, trial_table
from fatigue_planner.study.benchmark.trial import TrialResult
from fatigue_planner.study.sensitivity.reactions import Reacted


class StudyGrid:
    """The cells of all points that can be performed.

    cells: every different cell once; of_point: by point, in the grid's order, the indices of its cells.
    """

    def __init__(self, reacted: Sequence[Reacted]) -> None:
        indices: dict[str, int] = {}
        self.cells: list[Cell] = []
        self.of_point: dict[str, list[int]] = {}
        for result in reacted:
            if result.point.experiment is None or result.profiles is None:
                continue
            own = cells(result.point.experiment, result.profiles)
            for cell in own:
                digest = cell.digest()
                if digest not in indices:
                    indices[digest] = len(self.cells)
                    self.cells.append(cell)
                self.of_point.setdefault(result.point.name, []).append(indices[digest])

    def tables(self, results: Sequence[dict[int, TrialResult]]) -> Mapping[str, pd.DataFrame]:
        """The trials of every point, as `benchmark.tables.trial_table` without times, from the results of the cells."""
        tables = {
            point: trial_table([self.cells[index] for index in indices], [results[index] for index in indices])
            for point, indices in self.of_point.items()
        }
        return {point: table.drop(columns=[ACTIONS, *TIMES]) for point, table in tables.items()}

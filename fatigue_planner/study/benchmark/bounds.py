"""The cost that no policy can beat, for every condition and number of cycles; kept, as it takes seconds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from fatigue_planner.core.files import digest_of_package, publish_csv
from fatigue_planner.core.provenance import versions_of
from fatigue_planner.planners.bounds.cost_bound import CostBound, bound_of, fingerprint
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.study.benchmark.cell import NUMERICAL_LIBRARIES, Cell
from fatigue_planner.study.benchmark.job import Job
from fatigue_planner.study.benchmark.tables import read_keyed

BOUNDS_FILE = "bounds.csv"
CELL = ["condition", "n_cycles", "policy"]
BOUND_COLUMNS = ["cost_bound", "exact", "gap", "standard_error", "trials"]
# What produces a bound besides the scenario: folders and modules of this package.
SOURCES = ("planners/bounds", "fatigue", "pomdp", "core/jit.py", "core/pcg64.py")


@dataclass(frozen=True)
class BoundJob(Job[CostBound]):
    """The bound of a condition, whose worker is known, for one number of cycles: its only trial is 0."""

    condition: str
    n_cycles: int
    scenario: Scenario

    result_type = CostBound

    @property
    def name(self) -> str:
        """See Job.name."""
        return f"the bound of {self.condition}/{self.n_cycles}"

    @property
    def effort(self) -> int:
        """See Job.effort."""
        return self.n_cycles

    def key(self) -> Any:
        """See Job.key."""
        sources, libraries = digest_of_package(*SOURCES), versions_of(*NUMERICAL_LIBRARIES)
        return [fingerprint(self.scenario), self.n_cycles, sources, libraries]

    def trial_numbers(self) -> range:
        """See Job.trial_numbers."""
        return range(1)

    def run(self, trials: Sequence[int]) -> dict[int, CostBound]:
        """See Job.run."""
        return {trial: bound_of(self.scenario, self.n_cycles) for trial in trials}


def bound_jobs(cells: Sequence[Cell]) -> list[BoundJob]:
    """The bounds of the conditions and numbers of cycles with a known worker."""
    scenarios = {(cell.condition, cell.n_cycles): cell.scenario for cell in cells if cell.scenario.prior is None}
    return [BoundJob(*key, scenario) for key, scenario in scenarios.items()]


def bound_rows(jobs: Sequence[BoundJob], results: Sequence[Mapping[int, CostBound]]) -> pd.DataFrame:
    """One row per bound: condition, n_cycles, cost_bound, exact."""
    rows = [
        (job.condition, job.n_cycles, found[0].cost, found[0].exact) for job, found in zip(jobs, results, strict=True)
    ]
    return pd.DataFrame(rows, columns=["condition", "n_cycles", "cost_bound", "exact"])


def read_bounds(folder: Path, command: str) -> pd.DataFrame:
    """bounds.csv, which `command` makes: one row per cell whose worker is known. Raises as `table.read_table`."""
    return read_keyed(folder / BOUNDS_FILE, CELL, BOUND_COLUMNS, command, may_be_empty=["standard_error"])


def publish_bounds(folder: Path, table: pd.DataFrame) -> None:
    """Write bounds.csv."""
    publish_csv(folder / BOUNDS_FILE, table[CELL + BOUND_COLUMNS])

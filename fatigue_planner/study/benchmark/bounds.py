"""The cost that no policy can beat, for every condition and number of cycles; kept, as it takes seconds."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from fatigue_planner.core.errors import LostWorkError
from fatigue_planner.core.executors.executor import Executor, Lost
from fatigue_planner.core.files import (
    DIGEST_LENGTH,
    digest_of,
    digest_of_package,
    publish_csv,
    publish_with_checksum,
    read_with_checksum,
    remove_left_behind,
    set_aside,
)
from fatigue_planner.core.provenance import versions_of
from fatigue_planner.planners.bounds.cost_bound import CostBound, bound_of, fingerprint
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.tables import read_keyed

BOUNDS_FILE = "bounds.csv"
CELL = ["condition", "n_cycles", "policy"]
BOUND_COLUMNS = ["cost_bound", "exact", "gap", "standard_error", "trials"]
# What produces a bound besides the scenario: folders and modules of this package.
SOURCES = ("planners/bounds", "fatigue", "pomdp", "core/jit.py")
NUMERICAL_LIBRARIES = ("numpy", "numba", "llvmlite", "scipy")

CellKey = tuple[str, int]  # condition and number of cycles


def run_bounds(
    cells: Sequence[Cell], folder: Path, executor: Executor, progress: Callable[[], None]
) -> tuple[pd.DataFrame, list[str]]:
    """One row per condition and number of cycles with a known worker, and warnings about damaged files.

    The columns are condition, n_cycles, cost_bound, exact. Bounds already in the folder are not computed again.
    `progress` hears of each. What killed runs have left behind there is removed. Raises OutputFolderError,
    LostWorkError.
    """
    remove_left_behind(folder)
    scenarios = {(cell.condition, cell.n_cycles): cell.scenario for cell in cells if cell.scenario.prior is None}
    found: dict[CellKey, tuple[float, bool]] = {}
    missing: list[tuple[CellKey, Scenario]] = []
    warnings: list[str] = []
    for key, scenario in scenarios.items():
        kept = _read(folder, bound_digest(scenario, key[1]), warnings)
        if kept is None:
            missing.append((key, scenario))
        else:
            found[key] = kept
            progress()
    missing.sort(key=lambda part: -part[0][1])  # the longest first
    lost = []
    for index, bound in executor.run(_bound, missing):
        key, scenario = missing[index]
        if isinstance(bound, Lost):
            lost.append(f"the bound of {key[0]}, {key[1]} cycles: {bound.reason}.")
            continue
        digest = bound_digest(scenario, key[1])
        content = {"digest": digest, "n_cycles": key[1], "cost_bound": bound.cost, "exact": bound.exact}
        publish_with_checksum(_path(folder, digest), content)
        found[key] = bound.cost, bound.exact
        progress()
    if lost:
        raise LostWorkError("\n".join(lost))
    rows = [(condition, n_cycles, *found[condition, n_cycles]) for condition, n_cycles in scenarios]
    return pd.DataFrame(rows, columns=["condition", "n_cycles", "cost_bound", "exact"]), warnings


def read_bounds(folder: Path, command: str) -> pd.DataFrame:
    """bounds.csv, which `command` makes: one row per cell whose worker is known. Raises as `table.read_table`."""
    return read_keyed(folder / BOUNDS_FILE, CELL, BOUND_COLUMNS, command, may_be_empty=["standard_error"])


def publish_bounds(folder: Path, table: pd.DataFrame) -> None:
    """Write bounds.csv."""
    publish_csv(folder / BOUNDS_FILE, table[CELL + BOUND_COLUMNS])


def bound_digest(scenario: Scenario, n_cycles: int) -> str:
    """Key of a bound: everything that decides it."""
    return digest_of([fingerprint(scenario), n_cycles, digest_of_package(*SOURCES), versions_of(*NUMERICAL_LIBRARIES)])


def _path(folder: Path, digest: str) -> Path:
    return folder / f"{digest[:DIGEST_LENGTH]}.json"


def _bound(part: tuple[CellKey, Scenario]) -> CostBound:
    (_, n_cycles), scenario = part
    return bound_of(scenario, n_cycles)


def _read(folder: Path, digest: str, warnings: list[str]) -> tuple[float, bool] | None:
    """A kept bound; a damaged file, or one under a wrong name, is set aside with a warning."""
    path = _path(folder, digest)
    if not path.exists():
        return None
    content = read_with_checksum(path)
    if content is None or content.get("digest") != digest:
        set_aside(path)
        warnings.append(f"{path}: is damaged; it is set aside and its bound computed again.")
        return None
    return float(content["cost_bound"]), bool(content["exact"])

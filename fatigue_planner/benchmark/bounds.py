"""The cost that no policy can beat, for every condition and number of cycles; kept, as it takes seconds."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from fatigue_planner.benchmark.grid import Cell
from fatigue_planner.benchmark.table import read_keyed
from fatigue_planner.bounds.cost_bound import CostBound, cost_lower_bound
from fatigue_planner.errors import LostWorkError
from fatigue_planner.executors.executor import Executor, Lost
from fatigue_planner.files import (
    DIGEST_LENGTH,
    digest_of,
    digest_of_package,
    publish_csv,
    publish_sealed,
    read_sealed,
    set_aside,
)
from fatigue_planner.pomdp.situation import Situation

BOUNDS_FILE = "bounds.csv"
CELL = ["condition", "n_cycles", "policy"]
BOUND_COLUMNS = ["cost_bound", "exact", "gap", "standard_error", "trials"]
SOURCES = ("bounds", "fatigue", "pomdp")

Place = tuple[str, int]


def bound_of(situation: Situation, n_cycles: int) -> CostBound:
    """The bound of a situation whose worker is known."""
    model = situation.model
    live = model.live.size
    if live == 0:  # nothing ever tires
        return CostBound(cost=0.0, exact=True, state_revealed=False, exact_cycles=n_cycles, memory=0, seconds=0.0)
    shape = (len(model.actions), len(model.outcomes), -1)
    return cost_lower_bound(
        model.arrays.gain.reshape(shape)[:, :, :live],
        model.arrays.offset.reshape(shape)[:, :, :live],
        float(model.workers.expertise[0]),
        situation.states[:, :live],
        situation.weights,
        model.discount,
        model.entries,
        n_cycles,
    )


def run_bounds(cells: Sequence[Cell], folder: Path, executor: Executor, progress: Callable[[], None]) -> pd.DataFrame:
    """One row per condition and number of cycles with a known worker: condition, n_cycles, cost_bound, exact.

    Bounds already in the folder are not computed again. `progress` hears of each. Raises OutputFolderError,
    LostWorkError.
    """
    places = {(cell.condition, cell.n_cycles): cell.situation for cell in cells if cell.situation.prior is None}
    found: dict[Place, tuple[float, bool]] = {}
    missing = []
    for place, situation in places.items():
        kept = _read(_path(folder, situation, place))
        if kept is None:
            missing.append((place, situation))
        else:
            found[place] = kept
            progress()
    missing.sort(key=lambda part: -part[0][1])  # the longest first
    lost = []
    for index, bound in executor.run(_bound, missing):
        place, situation = missing[index]
        if isinstance(bound, Lost):
            lost.append(f"the bound of {place[0]}, {place[1]} cycles: {bound.reason}.")
            continue
        content = {"condition": place[0], "n_cycles": place[1], "cost_bound": bound.cost, "exact": bound.exact}
        publish_sealed(_path(folder, situation, place), content)
        found[place] = bound.cost, bound.exact
        progress()
    if lost:
        raise LostWorkError("\n".join(lost))
    rows = [(condition, n_cycles, *found[condition, n_cycles]) for condition, n_cycles in places]
    return pd.DataFrame(rows, columns=["condition", "n_cycles", "cost_bound", "exact"])


def read_bounds(folder: Path, command: str) -> pd.DataFrame:
    """bounds.csv, which `command` makes: one row per cell whose worker is known. Raises as `table.read_table`."""
    return read_keyed(folder / BOUNDS_FILE, CELL, BOUND_COLUMNS, command, may_be_empty=["standard_error"])


def publish_bounds(folder: Path, table: pd.DataFrame) -> None:
    """Write bounds.csv."""
    publish_csv(folder / BOUNDS_FILE, table[CELL + BOUND_COLUMNS])


def _path(folder: Path, situation: Situation, place: Place) -> Path:
    key = digest_of([situation.fingerprint(), place[1], digest_of_package(*SOURCES)])
    return folder / f"{key[:DIGEST_LENGTH]}.json"


def _bound(part: tuple[Place, Situation]) -> CostBound:
    (_, n_cycles), situation = part
    return bound_of(situation, n_cycles)


def _read(path: Path) -> tuple[float, bool] | None:
    """A kept bound; a damaged file is set aside."""
    if not path.exists():
        return None
    content = read_sealed(path)
    if content is None:
        set_aside(path)
        return None
    return float(content["cost_bound"]), bool(content["exact"])

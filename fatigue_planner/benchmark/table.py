"""The tidy table of trials: one row per run."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from fatigue_planner.benchmark.grid import Cell
from fatigue_planner.benchmark.runner import Results
from fatigue_planner.errors import DamagedFileError, MissingTableError
from fatigue_planner.files import publish_text

KEY = ["condition", "n_cycles", "policy", "trial"]
# Whether every run of the cell is the same, so that it was run once.
SAME = "deterministic"
OUTCOMES = ["discounted_return", "final_cost", "peak_cost"]
TIMES = ["mean_planning_time_s", "longest_planning_time_s"]
REGRETS = ["decision_loss", "run_loss", "agreement"]
TRIALS_FILE = "trials.csv"
TIMES_FILE = "planning_times.csv"
REGRET_FILE = "regret.csv"


def trial_table(cells: Sequence[Cell], results: Sequence[Results]) -> pd.DataFrame:
    """All columns of all trials, in the order of the cells and trials."""
    rows = [
        {"condition": cell.condition, "n_cycles": cell.n_cycles, "policy": cell.policy, "trial": trial}
        | {SAME: cell.is_deterministic()}
        | vars(done[trial])
        | (vars(done[trial].regret) if done[trial].regret else {})
        for cell, done in zip(cells, results, strict=True)
        for trial in sorted(done)
    ]
    regrets = REGRETS if any(cell.reference for cell in cells) else []
    return pd.DataFrame(rows, columns=[*KEY, SAME, *OUTCOMES, *regrets, *TIMES])


def publish_table(folder: Path, table: pd.DataFrame) -> None:
    """Write trials.csv and, because times are never the same twice, planning_times.csv apart from it.

    Where regret was measured, it goes to regret.csv.
    """
    if REGRETS[0] in table:
        publish_text(folder / REGRET_FILE, table[KEY + REGRETS].to_csv(index=False, lineterminator="\n"))
    publish_text(folder / TRIALS_FILE, table[[*KEY, SAME, *OUTCOMES]].to_csv(index=False, lineterminator="\n"))
    publish_text(folder / TIMES_FILE, table[KEY + TIMES].to_csv(index=False, lineterminator="\n"))


def read_table(folder: Path, command: str) -> pd.DataFrame:
    """The published trials (without times); `command` makes them, for the messages.

    Raises MissingTableError if there are none, DamagedFileError if the file is not such a table.
    """
    path = folder / TRIALS_FILE
    if not path.exists():
        raise MissingTableError(f"{path}: there is no table of trials. Run `{command}` first.")
    kinds = dict.fromkeys(OUTCOMES, float) | {"n_cycles": int, "trial": int, SAME: bool}
    try:
        table = pd.read_csv(path, dtype=kinds)
    except (ValueError, OSError) as error:
        raise DamagedFileError(f"{path}: is not a table of trials ({error}). Run `{command}`.") from error
    if list(table.columns) != [*KEY, SAME, *OUTCOMES] or table.isna().any(axis=None) or table.duplicated(KEY).any():
        raise DamagedFileError(f"{path}: is not a table of trials: columns, gaps or repeated rows. Run `{command}`.")
    return table

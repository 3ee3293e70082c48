"""The tidy tables of a benchmark: one row per run."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from fatigue_planner.core.errors import DamagedFileError, MissingTableError
from fatigue_planner.core.files import publish_csv
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.regret import Regret
from fatigue_planner.study.benchmark.trial import TrialResult

KEY = ["condition", "n_cycles", "policy", "trial"]
# Whether every run of the cell is the same, so that it was run once.
SAME = "deterministic"
OUTCOMES = ["discounted_return", "final_cost", "peak_cost"]
TIMES = ["mean_planning_time_s", "longest_planning_time_s"]
# The numbers of the actions taken, in the order of the cycles and of the experiment's actions.
ACTIONS = "actions"
REGRETS = ["decision_loss", "run_loss", "agreement"]
TRIALS_FILE = "trials.csv"
ACTIONS_FILE = "actions.csv"
TIMES_FILE = "planning_times.csv"
REGRET_FILE = "regret.csv"

# What every file holds besides the key.
COLUMNS = {TRIALS_FILE: [SAME, *OUTCOMES], ACTIONS_FILE: [ACTIONS], TIMES_FILE: TIMES, REGRET_FILE: REGRETS}
KINDS = {**dict.fromkeys([*OUTCOMES, *TIMES, *REGRETS], float), "n_cycles": int, "trial": int, SAME: bool}
KINDS |= dict.fromkeys(["condition", "policy", ACTIONS, "family", "first", "second", "note", "verdict"], str)


def trial_table(cells: Sequence[Cell], results: Sequence[dict[int, TrialResult]]) -> pd.DataFrame:
    """All columns of all trials, in the order of the cells and trials."""
    rows = [
        {**_key(cell, trial), SAME: same, **vars(done[trial]), ACTIONS: " ".join(map(str, done[trial].actions))}
        for cell, done in zip(cells, results, strict=True)
        for same in [cell.is_deterministic()]
        for trial in sorted(done)
    ]
    return pd.DataFrame(rows, columns=[*KEY, SAME, *OUTCOMES, ACTIONS, *TIMES])


def regret_rows(cells: Sequence[Cell], regrets: Sequence[dict[int, Regret]]) -> pd.DataFrame:
    """The regret of all trials, in the order of the cells and trials."""
    rows = [
        {**_key(cell, trial), **vars(done[trial])}
        for cell, done in zip(cells, regrets, strict=True)
        for trial in sorted(done)
    ]
    return pd.DataFrame(rows, columns=[*KEY, *REGRETS])


def publish_table(folder: Path, table: pd.DataFrame, files: Sequence[str]) -> None:
    """Write some of the tables; times, which are never the same twice, have a file of their own."""
    for file in files:
        publish_csv(folder / file, table[KEY + COLUMNS[file]])


def read_table(folder: Path, file: str, command: str) -> pd.DataFrame:
    """A published table; `command` makes it, for the messages.

    Raises MissingTableError if there is none, DamagedFileError if the file is not such a table; duplicate
    rows are named.
    """
    return read_keyed(folder / file, KEY, COLUMNS[file], command)


def read_keyed(
    path: Path, key: Sequence[str], columns: Sequence[str], command: str, may_be_empty: Sequence[str] = ()
) -> pd.DataFrame:
    """A table of key and columns in which each key is there once; an empty text is "". Raises as `read_table`."""
    if not path.exists():
        raise MissingTableError(f"{path}: there is no such table. Run `{command}` first.")
    try:
        table = pd.read_csv(path, dtype=KINDS, keep_default_na=False, na_values=[""])
    except (ValueError, OSError) as error:
        raise DamagedFileError(f"{path}: is not one of our tables ({error}). Run `{command}`.") from error
    if list(table.columns) != [*key, *columns] or table.drop(columns=list(may_be_empty)).isna().any(axis=None):
        raise DamagedFileError(f"{path}: is not one of our tables: columns or gaps. Run `{command}`.")
    texts = [name for name in may_be_empty if KINDS.get(name) is str]
    table[texts] = table[texts].fillna("")
    duplicate = table.duplicated(list(key))
    if duplicate.any():
        raise DamagedFileError(
            f"{path}: has duplicate rows: {name_rows(table[duplicate], key)}{_different(table, key)}. Run `{command}`."
        )
    return table


def actions_of(text: str) -> list[int]:
    """The actions of a run. Raises ValueError if the text does not list actions."""
    return [int(number) for number in text.split(" ")]


def name_rows(rows: pd.DataFrame, key: Sequence[str] = KEY) -> str:
    """The keys of some rows, the first few, as a message shows them."""
    shown = ["/".join(map(str, values)) for values in rows[list(key)].head(5).itertuples(index=False)]
    more = len(rows) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")


def _different(table: pd.DataFrame, key: Sequence[str]) -> str:
    """The first two rows with the same key but different values, as a message shows them; else empty."""
    rows = table.drop_duplicates()
    rows = rows[rows.duplicated(list(key), keep=False)]
    if rows.empty:
        return ""
    same = rows[(rows[list(key)] == rows[list(key)].iloc[0]).all(axis=1)].drop(columns=list(key)).head(2)
    return ", with different values: " + " and ".join(str(tuple(row)) for row in same.to_numpy().tolist())


def _key(cell: Cell, trial: int) -> dict[str, Any]:
    return {"condition": cell.condition, "n_cycles": cell.n_cycles, "policy": cell.policy, "trial": trial}

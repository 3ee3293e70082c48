"""The published tables of an experiment, checked against its settings, row by row, before anything is made of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from fatigue_planner.benchmark.bounds import BOUNDS_FILE
from fatigue_planner.benchmark.grid import Cell
from fatigue_planner.benchmark.replay import Course, replay
from fatigue_planner.benchmark.table import (
    ACTIONS,
    ACTIONS_FILE,
    KEY,
    REGRET_FILE,
    SAME,
    TRIALS_FILE,
    actions_of,
    name_rows,
    read_table,
)
from fatigue_planner.errors import DamagedFileError, StaleTableError
from fatigue_planner.experiment.resolve import reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.provenance import check_intact, read_note
from fatigue_planner.reactions.reaction import digests

# Settings that the tables do not depend on.
NOT_IN_THE_TABLES = ("figures", "statistics")


@dataclass(frozen=True)
class Results:
    """The tables in a results folder; regret and bounds where they were made; note: what the manifest says of them."""

    trials: pd.DataFrame
    actions: pd.DataFrame
    regret: pd.DataFrame | None
    bounds: pd.DataFrame | None
    note: dict[str, Any]


def load_results(experiment: Experiment, folder: Path, command: str) -> Results:
    """The tables of an experiment's whole grid; `command` makes them, for the messages.

    Raises MissingTableError if there are none; StaleTableError if they were made with other settings, with what
    differs; DamagedFileError, naming them, for rows that stand twice, are missing or belong to no cell of the grid,
    and for files that are not what was written.
    """
    trials = read_table(folder, TRIALS_FILE, command)
    note = read_note(folder, "benchmark", command)
    _check_origin(note, experiment, folder / TRIALS_FILE, command)
    _check_rows(trials, _expected_keys(experiment.plain()["benchmark"], trials), folder / TRIALS_FILE, command)
    actions = read_table(folder, ACTIONS_FILE, command)
    _check_rows(actions, trials[KEY], folder / ACTIONS_FILE, command)
    regret = read_table(folder, REGRET_FILE, command) if (folder / REGRET_FILE).exists() else None
    if regret is not None:
        _check_rows(regret, trials[KEY], folder / REGRET_FILE, command)
    bounds = pd.read_csv(folder / BOUNDS_FILE) if (folder / BOUNDS_FILE).exists() else None
    made = [TRIALS_FILE, ACTIONS_FILE, *([REGRET_FILE] if regret is not None else [])]
    for file in [*made, *([BOUNDS_FILE] if bounds is not None else [])]:
        check_intact(folder, note, file, command)
    return Results(trials, actions, regret, bounds, note)


def load_folder(folder: Path) -> tuple[dict[str, Any], pd.DataFrame]:
    """What the manifest of a results folder says of its tables, and its trials, whatever the experiment was.

    Raises as `load_results`.
    """
    command = "fatplan benchmark"
    trials = read_table(folder, TRIALS_FILE, command)
    note = read_note(folder, "benchmark", command)
    _check_rows(trials, _expected_keys(note["experiment"]["benchmark"], trials), folder / TRIALS_FILE, command)
    check_intact(folder, note, TRIALS_FILE, command)
    return note, trials


def _expected_keys(grid: Mapping[str, Any], trials: pd.DataFrame) -> pd.DataFrame:
    """The keys a table of a grid must have; the table says which cells are deterministic."""
    same = trials.groupby(KEY[:3])[SAME].all()
    rows = [
        (condition, n_cycles, policy, trial)
        for condition in grid["conditions"]
        for n_cycles in grid["n_cycles"]
        for policy in grid["policies"]
        for trial in range(1 if same.get((condition, n_cycles, policy), False) else grid["trials"])
    ]
    return pd.DataFrame(rows, columns=KEY)


def courses(grid: Sequence[Cell], results: Results, folder: Path) -> dict[tuple[str, int, str], list[Course]]:
    """The course of every run by condition, length and policy, lived through again from the actions it took.

    Raises DamagedFileError, naming the runs, where a course does not come to the return in the table: such a row is
    of another configuration.
    """
    table = results.trials.merge(results.actions, on=KEY)
    cells = {(cell.condition, cell.n_cycles, cell.policy): cell for cell in grid}
    found: dict[tuple[str, int, str], list[Course]] = {key: [] for key in cells}
    foreign = []
    columns = (table[name].tolist() for name in [*KEY, ACTIONS, "discounted_return"])
    for place, (*key, trial, text, discounted_return) in enumerate(zip(*columns, strict=True)):
        condition, n_cycles, policy = key
        course = _course(cells[condition, n_cycles, policy], trial, text)
        if course is None or course.discounted_return != discounted_return:
            foreign.append(place)
        else:
            found[condition, n_cycles, policy].append(course)
    if foreign:
        raise DamagedFileError(
            f"{folder / TRIALS_FILE}: not from this configuration, for its actions do not come to its return: "
            f"{name_rows(table.iloc[foreign])}. Run `fatplan benchmark` again."
        )
    return found


def _course(cell: Cell, trial: int, text: str) -> Course | None:
    try:
        actions = actions_of(text)
    except ValueError:
        return None
    known = len(cell.situation.model.actions)
    if len(actions) != cell.n_cycles or not all(0 <= action < known for action in actions):
        return None
    return replay(cell, trial, actions)


def _check_rows(table: pd.DataFrame, expected: pd.DataFrame, path: Path, command: str) -> None:
    """Raise DamagedFileError, naming the rows, unless the table has just the expected ones."""
    both = table[KEY].merge(expected, on=KEY, how="outer", indicator=True)
    for side, words in (("left_only", "belong to no cell of the experiment"), ("right_only", "are missing")):
        rows = both[both["_merge"] == side]
        if len(rows):
            raise DamagedFileError(f"{path}: {len(rows)} rows {words}: {name_rows(rows)}. Run `{command}`.")


def _check_origin(note: dict[str, Any], experiment: Experiment, path: Path, command: str) -> None:
    made, now = note.get("experiment", {}), experiment.plain()
    changed = [key for key in now if key not in NOT_IN_THE_TABLES and made.get(key) != now[key]]
    if note.get("reactions") != digests(reaction_requests(experiment)):
        changed.append("reactions")
    if changed:
        raise StaleTableError(f"{path}: was made with other settings ({', '.join(changed)}). Run `{command}`.")

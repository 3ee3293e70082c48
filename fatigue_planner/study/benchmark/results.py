"""The published tables of an experiment, checked against its settings, row by row, before anything is made of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import pandas as pd
from pydantic import BaseModel, model_validator

from fatigue_planner.core.errors import DamagedFileError, StaleTableError
from fatigue_planner.core.provenance import Note, check_intact, read_note
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.settings import ReferenceSettings
from fatigue_planner.reactions.reaction import digests
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE, CELL, read_bounds
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import Course, replay
from fatigue_planner.study.benchmark.tables import (
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

# Settings that the tables do not depend on.
NOT_IN_THE_TABLES = ("figures", "statistics")


class NotedGrid(BaseModel):
    """The grid that tables were made of, as far as their rows go."""

    conditions: dict[str, Any]
    n_cycles: tuple[int, ...]
    policies: dict[str, Any]
    trials: int


class NotedExperiment(BaseModel):
    """The part of a noted experiment that every version has."""

    benchmark: NotedGrid


class BenchmarkNote(Note):
    """What `fatplan benchmark` notes: the experiment as plain values, seed, and the references of the regret.

    actions: by condition, the actions its worker can perform, which the numbers in the table of actions count;
    conditions that could not be run are not among them.
    """

    experiment: dict[str, Any]
    actions: dict[str, tuple[str, ...]]
    seed: int
    references: dict[str, ReferenceSettings]

    @model_validator(mode="after")
    def _check_grid(self) -> Self:
        _ = self.grid
        return self

    @property
    def grid(self) -> NotedGrid:
        """The grid of the tables."""
        grid = NotedExperiment.model_validate(self.experiment).benchmark
        conditions = {name: condition for name, condition in grid.conditions.items() if name in self.actions}
        return grid.model_copy(update={"conditions": conditions})


@dataclass(frozen=True)
class Results:
    """The tables in a results folder; regret and bounds where they were made; note: what the manifest says of them."""

    trials: pd.DataFrame
    actions: pd.DataFrame
    regret: pd.DataFrame | None
    bounds: pd.DataFrame | None
    note: BenchmarkNote

    @property
    def options(self) -> str:
        """The options that make all of these tables."""
        return f"{'' if self.regret is None else ' --regret'}{'' if self.bounds is None else ' --bound'}"


def load_results(experiment: Experiment, folder: Path, command: str) -> Results:
    """The tables of an experiment's whole grid; `command` makes them, for the messages.

    Raises MissingTableError if there are none; StaleTableError if they were made with other settings, with what
    differs; DamagedFileError, naming them, for rows that stand twice, are missing or belong to no cell of the grid,
    and for files that are not what was written.
    """
    there = {file: (folder / file).exists() for file in (REGRET_FILE, BOUNDS_FILE)}
    # the same command without these options would remove what they made
    command += "".join(f" {option}" for file, option in zip(there, ("--regret", "--bound"), strict=True) if there[file])
    trials = read_table(folder, TRIALS_FILE, command)
    note = read_note(folder, "benchmark", BenchmarkNote, command)
    _check_origin(note, experiment, folder / TRIALS_FILE, command)
    _check_rows(trials, _expected_keys(note.grid, trials), folder / TRIALS_FILE, command)
    actions = read_table(folder, ACTIONS_FILE, command)
    _check_rows(actions, trials[KEY], folder / ACTIONS_FILE, command)
    regret = bounds = None
    if there[REGRET_FILE]:
        regret = read_table(folder, REGRET_FILE, command)
        _check_rows(regret, trials[KEY], folder / REGRET_FILE, command)
    if there[BOUNDS_FILE]:
        bounds = read_bounds(folder, command)
        known = [name for name, one in experiment.benchmark.conditions.items() if one.hidden_worker is None]
        cells = trials.loc[trials["condition"].isin(known), CELL].drop_duplicates()
        _check_rows(bounds, cells, folder / BOUNDS_FILE, command, CELL)
    for file in (TRIALS_FILE, ACTIONS_FILE, *(file for file in there if there[file])):
        check_intact(folder, note, file, command)
    return Results(trials, actions, regret, bounds, note)


def load_folder(folder: Path) -> tuple[BenchmarkNote, pd.DataFrame]:
    """What the manifest of a results folder says of its tables, and its trials, whatever the experiment was.

    Raises as `load_results`.
    """
    command = "fatplan benchmark"
    trials = read_table(folder, TRIALS_FILE, command)
    note = read_note(folder, "benchmark", BenchmarkNote, command)
    _check_rows(trials, _expected_keys(note.grid, trials), folder / TRIALS_FILE, command)
    check_intact(folder, note, TRIALS_FILE, command)
    return note, trials


def _expected_keys(grid: NotedGrid, trials: pd.DataFrame) -> pd.DataFrame:
    """The keys a table of a grid must have; the table says which cells are deterministic."""
    same = trials.groupby(KEY[:3])[SAME].all()
    rows = [
        (condition, n_cycles, policy, trial)
        for condition in grid.conditions
        for n_cycles in grid.n_cycles
        for policy in grid.policies
        for trial in range(1 if same.get((condition, n_cycles, policy), False) else grid.trials)
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
    known = len(cell.scenario.model.actions)
    if len(actions) != cell.n_cycles or not all(0 <= action < known for action in actions):
        return None
    return replay(cell, trial, actions)


def _check_rows(
    table: pd.DataFrame, expected: pd.DataFrame, path: Path, command: str, key: Sequence[str] = KEY
) -> None:
    """Raise DamagedFileError, naming the rows, unless the table has just the expected ones."""
    both = table[list(key)].merge(expected, on=list(key), how="outer", indicator=True)
    sides = {"left_only": "in no cell of the experiment", "right_only": "missing"}
    for side, words in sides.items():
        rows = both[both["_merge"] == side]
        if len(rows):
            count = "1 row is" if len(rows) == 1 else f"{len(rows)} rows are"
            raise DamagedFileError(f"{path}: {count} {words}: {name_rows(rows, key)}. Run `{command}`.")


def _check_origin(note: BenchmarkNote, experiment: Experiment, path: Path, command: str) -> None:
    made, now = note.experiment, experiment.plain()
    changed = [key for key in now if key not in NOT_IN_THE_TABLES and made.get(key) != now[key]]
    if note.reactions != digests(reaction_requests(experiment)):
        changed.append("reactions")
    if changed:
        raise StaleTableError(f"{path}: was made with other settings ({', '.join(changed)}). Run `{command}`.")

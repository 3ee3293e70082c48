"""The published tables of an experiment, checked against its settings, row by row, before anything is made of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import pandas as pd
from pydantic import BaseModel, model_validator

from fatigue_planner.core.errors import DamagedFileError, MissingTableError, StaleTableError, listed
from fatigue_planner.core.files import remove, set_aside
from fatigue_planner.core.provenance import MANIFEST_FILE, Note, check_intact, read_note, sha256, versions
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.planners.lookahead import ReferenceSettings
from fatigue_planner.reactions.reaction import digests
from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE, CELL, read_bounds
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.replay import Course, replay
from fatigue_planner.study.benchmark.selection import Selection
from fatigue_planner.study.benchmark.tables import (
    ACTIONS,
    ACTIONS_FILE,
    KEY,
    REGRET_FILE,
    SAME,
    TRIALS_FILE,
    actions_of,
    name_rows,
    read_keyed,
    read_table,
)
from fatigue_planner.study.statistics.comparison import RANK_COLUMNS
from fatigue_planner.study.statistics.contrast import COLUMNS

EXPERIMENT_FILE = "experiment.yaml"
COMPARISON_FILE = "comparison.csv"
CONTRASTS_FILE = "contrasts.csv"
# What has a row of its own in comparison.csv, in contrasts.csv.
RANK = ["condition", "n_cycles", "rank"]
PAIR = ["family", "condition", "n_cycles", "first", "second"]


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

    selection: what the options asked of the experiment's file, whose copy is EXPERIMENT_FILE. actions: by condition,
    the actions its worker can perform, which the numbers in the table of actions count; conditions that could not be
    run are not among them.
    """

    experiment: dict[str, Any]
    selection: Selection = Selection()
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
    """The tables in a results folder; regret and bounds where they were made; note: what the manifest says of them.

    comparison: `comparison_table`'s; contrasts: `contrasts`'s; bounds: `gap_table`'s.
    """

    trials: pd.DataFrame
    actions: pd.DataFrame
    comparison: pd.DataFrame
    contrasts: pd.DataFrame
    regret: pd.DataFrame | None
    bounds: pd.DataFrame | None
    note: BenchmarkNote

    @property
    def options(self) -> str:
        """The options that make all of these tables."""
        return f"{'' if self.regret is None else ' --regret'}{'' if self.bounds is None else ' --bound'}"


def load_results(experiment: Experiment, folder: Path, command: str) -> Results:
    """The tables of an experiment's grid; `command` makes them, for the messages.

    Raises MissingTableError if there are none; StaleTableError if they were made with other settings, with what
    differs; DamagedFileError, naming them, for rows that are duplicates, are missing or belong to no cell of the grid,
    and for files that are not what was written.
    """
    there = {file: (folder / file).exists() for file in OPTIONAL_FILES}
    command += "".join(f" {option}" for file, option in OPTIONAL_FILES.items() if there[file])
    trials = read_table(folder, TRIALS_FILE, command)
    note = read_note(folder, "benchmark", BenchmarkNote, command)
    _check_origin(note, experiment, folder, command)
    _check_rows(trials, _expected_keys(note.grid, trials), folder / TRIALS_FILE, command)
    actions = read_table(folder, ACTIONS_FILE, command)
    _check_rows(actions, trials[KEY], folder / ACTIONS_FILE, command)
    comparison, contrasted = _read_comparisons(folder, command)
    regret = bounds = None
    if there[REGRET_FILE]:
        regret = read_table(folder, REGRET_FILE, command)
        _check_rows(regret, trials[KEY], folder / REGRET_FILE, command)
    if there[BOUNDS_FILE]:
        bounds = read_bounds(folder, command)
        known = [name for name, condition in experiment.benchmark.conditions.items() if condition.hidden_worker is None]
        cells = comparison.loc[comparison["condition"].isin(known), CELL]
        _check_rows(bounds, cells, folder / BOUNDS_FILE, command, CELL)
    optional = [file for file in there if there[file]]
    for file in (TRIALS_FILE, ACTIONS_FILE, COMPARISON_FILE, CONTRASTS_FILE, *optional):
        check_intact(folder, note, file, command)
    return Results(trials, actions, comparison, contrasted, regret, bounds, note)


# Tables that only runs with an option make, and the option.
OPTIONAL_FILES = {REGRET_FILE: "--regret", BOUNDS_FILE: "--bound"}


def keep_or_remove(
    experiment: Experiment, folder: Path, files: Sequence[str]
) -> tuple[dict[str, BenchmarkNote], list[str]]:
    """Which of these optional files, of earlier runs, still belong to the experiment and to the runs in the folder.

    It is asked when trials.csv and actions.csv are written anew, but not the manifest. Returns, by file, the note of
    the run that made it, and warnings: what belongs to other runs is removed, what is damaged set aside. Raises
    OutputFolderError if that cannot be done.
    """
    kept: dict[str, BenchmarkNote] = {}
    warnings = []
    for path in [folder / file for file in files if (folder / file).exists()]:
        again = f"`{OPTIONAL_FILES[path.name]}` makes it again."
        try:
            note = read_note(folder, "benchmark", BenchmarkNote, "")
            check_intact(folder, note, path.name, "")
        except DamagedFileError:
            warnings.append(f"{path}: is not what was written; it is now {set_aside(path).name}. {again}")
            continue
        changed = [key for key in _changed_settings(note, experiment) if key != "statistics"]
        changed += ["versions"] if note.versions != versions() else []
        if not changed and any(note.sha256.get(name) != sha256(folder / name) for name in (TRIALS_FILE, ACTIONS_FILE)):
            changed.append("runs")
        if changed:
            remove(path)
            warnings.append(f"{path}: was of an earlier run (different: {listed(changed)}) and is removed. {again}")
        else:
            kept[path.name] = note
    return kept, warnings


def _read_comparisons(folder: Path, command: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    ranks = [name for name in RANK_COLUMNS if name not in RANK]
    comparison = read_keyed(folder / COMPARISON_FILE, RANK, ranks, command, may_be_empty=["p_value", "verdict"])
    numbers = [name for name in COLUMNS if name not in PAIR]
    return comparison, read_keyed(folder / CONTRASTS_FILE, PAIR, numbers, command, may_be_empty=numbers)


def load_source(folder: Path, command: str) -> tuple[Path, Selection]:
    """The experiment file that a results folder was made of, which lies in it, and what the options asked of it.

    Raises MissingTableError if `command`, a benchmark, has not written there; DamagedFileError if it is not what was
    written.
    """
    if not (folder / MANIFEST_FILE).exists():
        raise MissingTableError(f"{folder}: is not a results folder, for it has no {MANIFEST_FILE}. Run `{command}`.")
    note = read_note(folder, "benchmark", BenchmarkNote, command)
    check_intact(folder, note, EXPERIMENT_FILE, command)
    return folder / EXPERIMENT_FILE, note.selection


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
    """The course of every run by condition, length and policy, replayed from the actions it took.

    Raises DamagedFileError, naming the runs, where a replay does not give the return in the table: such a row is of
    another configuration.
    """
    table = results.trials.merge(results.actions, on=KEY)
    cells = {(cell.condition, cell.n_cycles, cell.policy): cell for cell in grid}
    found: dict[tuple[str, int, str], list[Course]] = {key: [] for key in cells}
    foreign = []
    columns = (table[name].tolist() for name in [*KEY, ACTIONS, "discounted_return"])
    for index, (*key, trial, text, discounted_return) in enumerate(zip(*columns, strict=True)):
        condition, n_cycles, policy = key
        course = _course(cells[condition, n_cycles, policy], trial, text)
        if course is None or course.discounted_return != discounted_return:
            foreign.append(index)
        else:
            found[condition, n_cycles, policy].append(course)
    if foreign:
        raise DamagedFileError(
            f"{folder / TRIALS_FILE}: not from this configuration, since its actions do not give its return: "
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


def _check_origin(note: BenchmarkNote, experiment: Experiment, folder: Path, command: str) -> None:
    changed = _changed_settings(note, experiment)
    if changed:
        path = folder / (CONTRASTS_FILE if changed == ["statistics"] else TRIALS_FILE)
        raise StaleTableError(f"{path}: was made with other settings ({', '.join(changed)}). Run `{command}`.")


def _changed_settings(note: BenchmarkNote, experiment: Experiment) -> list[str]:
    """What decides the tables and has changed since they were made."""
    made, now = note.experiment, experiment.plain()
    changed = [key for key in now if key != "figures" and made.get(key) != now[key]]
    return changed + (["reactions"] if note.reactions != digests(reaction_requests(experiment)) else [])

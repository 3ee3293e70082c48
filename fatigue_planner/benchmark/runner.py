"""Running a grid of cells on all cores, resuming where an earlier run stopped."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from fatigue_planner.benchmark.grid import Cell
from fatigue_planner.benchmark.store import TrialStore
from fatigue_planner.benchmark.trial import Reference, TrialResult, draw_world, run_trial
from fatigue_planner.parallel import run_parallel
from fatigue_planner.planners.lookahead import LookaheadPolicy
from fatigue_planner.planners.registry import build_policy
from fatigue_planner.planners.settings import PomcpSettings
from fatigue_planner.streams import stream

TRIALS_PER_PART = 5

Results = dict[int, TrialResult]


def run_cell(cell: Cell, trials: Sequence[int]) -> Results:
    """Some trials of a cell."""
    results = {}
    for trial in trials:
        world = draw_world(cell.seed, cell.condition, cell.n_cycles, trial)
        planner = stream(cell.seed, "planner", cell.condition, cell.n_cycles, trial, cell.policy)
        policy = build_policy(cell.settings)
        reference = None
        if cell.reference is not None:
            draws = stream(cell.seed, "reference", cell.condition, cell.n_cycles, trial, cell.policy)
            reference = Reference(LookaheadPolicy(cell.reference), draws)
        knows = cell.settings.knows
        results[trial] = run_trial(cell.situation, policy, knows, cell.n_cycles, world, planner, reference)
    return results


def run_grid(
    cells: Sequence[Cell], store_folder: Path, jobs: int, progress: Callable[[Cell, int], None]
) -> tuple[list[Results], list[str]]:
    """All trials of all cells, in the order of the cells, and warnings about damaged files.

    Trials already in the store are not run again; new ones are stored as they come. `progress` hears
    how many trials of a cell are done. Raises OutputFolderError if the store cannot be written.
    """
    store = TrialStore(store_folder)
    results: list[Results] = []
    parts: list[tuple[int, list[int]]] = []
    for index, cell in enumerate(cells):
        finished = store.load(cell)
        results.append({trial: finished[trial] for trial in cell.trial_numbers() if trial in finished})
        progress(cell, len(results[index]))
        missing = [trial for trial in cell.trial_numbers() if trial not in finished]
        parts += [(index, missing[i : i + TRIALS_PER_PART]) for i in range(0, len(missing), TRIALS_PER_PART)]
    parts.sort(key=lambda part: -cells[part[0]].n_cycles * len(part[1]))
    work = [(cells[index], trials, store_folder) for index, trials in parts]
    for place, done in run_parallel(_run_and_keep, work, jobs):
        index = parts[place][0]
        results[index] |= done
        progress(cells[index], len(done))
    return results, store.warnings


def _run_and_keep(part: tuple[Cell, list[int], Path]) -> Results:
    """Run some trials and store them at once, whatever becomes of the parent process."""
    cell, trials, store_folder = part
    _load_compiled_code(cell, trials if cell.situation.prior else trials[:1])
    results = run_cell(cell, trials)
    TrialStore(store_folder).add(cell, results)
    return results


def _load_compiled_code(cell: Cell, trials: Sequence[int]) -> None:
    """Throw-away decisions, one per worker, so that no planning time includes loading or compiling code."""
    settings, rng = cell.settings, np.random.default_rng(0)
    if isinstance(settings, PomcpSettings):
        settings = settings.model_copy(update={"descents": 1, "seconds": None})
    for trial in trials:
        world = cell.situation.worker(draw_world(cell.seed, cell.condition, cell.n_cycles, trial).worker)
        build_policy(settings).act(cell.situation.initial_belief(settings.knows, world, rng), rng)

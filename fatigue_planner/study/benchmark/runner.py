"""Doing many jobs, resuming where an earlier run stopped."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from fatigue_planner.core.errors import LostWorkError
from fatigue_planner.core.executors.executor import Executor, Lost
from fatigue_planner.core.files import remove_left_behind
from fatigue_planner.study.benchmark.job import Job
from fatigue_planner.study.benchmark.store import TrialStore

TRIALS_PER_PART = 5

T = TypeVar("T")


def run_grid(
    grid: Sequence[Job[T]], store_folder: Path, executor: Executor, progress: Callable[[Job[T], int], None]
) -> tuple[list[dict[int, T]], list[str]]:
    """All trials of all jobs of a grid, in its order, and warnings about damaged files.

    Trials already in the store are not run again; new ones are stored as they come. `progress` hears how many trials of
    a job are done. What killed runs have left behind in the store is removed. Raises OutputFolderError if the store
    cannot be written; LostWorkError, when all others are done, if some trials kill their workers.
    """
    remove_left_behind(store_folder)
    store = TrialStore(store_folder)
    results: list[dict[int, T]] = []
    parts: list[tuple[int, list[int]]] = []
    for index, job in enumerate(grid):
        finished = store.load(job)
        results.append({trial: finished[trial] for trial in job.trial_numbers() if trial in finished})
        progress(job, len(results[index]))
        missing = [trial for trial in job.trial_numbers() if trial not in finished]
        parts += [(index, missing[i : i + TRIALS_PER_PART]) for i in range(0, len(missing), TRIALS_PER_PART)]
    parts.sort(key=lambda part: -grid[part[0]].effort * len(part[1]))
    lost = []
    for position, done in executor.run(_run, [(grid[index].part(trials), trials) for index, trials in parts]):
        index, trials = parts[position]
        if isinstance(done, Lost):
            lost.append(f"{grid[index].name}, trials {trials[0]} to {trials[-1]}: {done.reason}")
            continue
        store.add(grid[index], done)
        results[index] |= done
        progress(grid[index], len(done))
    if lost:
        raise LostWorkError("\n".join(lost) + "\nAll other trials are kept; the same command tries these again.")
    return results, store.warnings


def _run(part: tuple[Job[Any], list[int]]) -> dict[int, Any]:
    job, trials = part
    return job.run(trials)

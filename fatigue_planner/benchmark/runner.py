"""Doing many jobs on all cores, resuming where an earlier run stopped."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from fatigue_planner.benchmark.job import Job
from fatigue_planner.benchmark.store import TrialStore
from fatigue_planner.parallel import run_parallel

TRIALS_PER_PART = 5

T = TypeVar("T")


def run_grid(
    grid: Sequence[Job[T]], store_folder: Path, jobs: int, progress: Callable[[Job[T], int], None]
) -> tuple[list[dict[int, T]], list[str]]:
    """All trials of all jobs of a grid, in its order, and warnings about damaged files.

    Trials already in the store are not run again; new ones are stored as they come. `progress` hears
    how many trials of a job are done. Raises OutputFolderError if the store cannot be written.
    """
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
    work = [(grid[index], trials, store_folder) for index, trials in parts]
    for place, done in run_parallel(_run_and_keep, work, jobs):
        index = parts[place][0]
        results[index] |= done
        progress(grid[index], len(done))
    return results, store.warnings


def _run_and_keep(part: tuple[Job[Any], list[int], Path]) -> dict[int, Any]:
    """Run some trials and store them at once, whatever becomes of the parent process."""
    job, trials, store_folder = part
    results = job.run(trials)
    TrialStore(store_folder).add(job, results)
    return results

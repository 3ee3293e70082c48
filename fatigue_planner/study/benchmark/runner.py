"""Doing many jobs, resuming where an earlier run stopped, from the finished trials on disk.

`<digest of the job>/<first>-<last>.json` holds some trials of a job and the SHA-256 of what it says; each file is
published whole. Trials are keyed by job and number, so it does not matter how a run cut them into parts.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from fatigue_planner.core.errors import DamagedFileError, LostWorkError
from fatigue_planner.core.executors.executor import Executor, Lost
from fatigue_planner.core.files import (
    DIGEST_LENGTH,
    publish_with_checksum,
    read_with_checksum,
    remove_left_behind,
    set_aside,
)
from fatigue_planner.study.benchmark.job import Job

TRIALS_PER_PART = 5

T = TypeVar("T")


class TrialStore:
    """The finished trials below one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.warnings: list[str] = []

    def add(self, job: Job[T], results: Mapping[int, T]) -> None:
        """Keep some trials of a job. Raises OutputFolderError if they cannot be written."""
        rows = [{"trial": trial, **vars(results[trial])} for trial in sorted(results)]
        digest = job.digest()
        content = {"cell": job.name, "digest": digest, "trials": rows}
        publish_with_checksum(self._folder(digest) / f"{min(results)}-{max(results)}.json", content)

    def load(self, job: Job[T]) -> dict[int, T]:
        """The finished trials of a job, by number.

        A damaged part is set aside with a warning; two different results of one trial raise
        DamagedFileError, showing both.
        """
        found: dict[int, T] = {}
        digest, kind = job.digest(), TypeAdapter(job.result_type)
        for path in sorted(self._folder(digest).glob("[0-9]*.json")):
            for number, result in self._read(path, digest, kind):
                if not job.accepts(number, result):
                    continue
                earlier = found.setdefault(number, result)
                if earlier != result:
                    raise DamagedFileError(
                        f"{path}: trial {number} of {job.name} has two results, {earlier} and {result}. Remove "
                        f"{path.parent} and run again."
                    )
        return found

    def _folder(self, digest: str) -> Path:
        return self.folder / digest[:DIGEST_LENGTH]

    def _read(self, path: Path, digest: str, kind: TypeAdapter[T]) -> list[tuple[int, T]]:
        content = read_with_checksum(path)
        try:
            if content is not None and content["digest"] == digest:
                return [(int(row.pop("trial")), kind.validate_python(row)) for row in content["trials"]]
        except (ValueError, KeyError, TypeError, AttributeError):
            pass
        set_aside(path)
        self.warnings.append(f"{path}: is damaged; it is set aside, and what it held is done again.")
        return []


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
        size = max(TRIALS_PER_PART, job.trials_at_once)
        parts += [(index, missing[i : i + size]) for i in range(0, len(missing), size)]
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

"""Finished trials on disk: small files, each published whole, from which a run goes on and a table is made.

`<digest of the job>/<first>-<last>.json` holds some trials of a job and the SHA-256 of what it says. Trials are
keyed by job and number, so it does not matter how a run cut them into parts.
"""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

from fatigue_planner.core.errors import DamagedFileError
from fatigue_planner.core.files import DIGEST_LENGTH, publish_with_checksum, read_with_checksum, set_aside
from fatigue_planner.study.benchmark.job import Job

T = TypeVar("T")


class TrialStore:
    """The finished trials below one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.warnings: list[str] = []

    def add(self, job: Job[T], results: Mapping[int, T]) -> None:
        """Keep some trials of a job. Raises OutputFolderError if they cannot be written."""
        rows: list[Any] = [{"trial": trial, **asdict(results[trial])} for trial in sorted(results)]  # type: ignore[call-overload]
        digest = job.digest()
        content = {"cell": job.name, "digest": digest, "trials": rows}
        publish_with_checksum(self._folder(digest) / f"{min(results)}-{max(results)}.json", content)

    def load(self, job: Job[T]) -> dict[int, T]:
        """The finished trials of a job, by number.

        A damaged part is set aside with a warning; two different results of one trial raise
        DamagedFileError, showing both.
        """
        found: dict[int, T] = {}
        digest = job.digest()
        for path in sorted(self._folder(digest).glob("[0-9]*.json")):
            for number, result in self._read(path, digest, job):
                if not job.accepts(number, result):
                    continue
                earlier = job.outcome(found.setdefault(number, result))
                if earlier != job.outcome(result):
                    raise DamagedFileError(
                        f"{path}: trial {number} of {job.name} has two results, {earlier} and "
                        f"{job.outcome(result)}. Remove {path.parent} and run again."
                    )
        return found

    def _folder(self, digest: str) -> Path:
        return self.folder / digest[:DIGEST_LENGTH]

    def _read(self, path: Path, digest: str, job: Job[T]) -> list[tuple[int, T]]:
        content = read_with_checksum(path)
        try:
            if content is not None and content["digest"] == digest:
                return [(int(row.pop("trial")), job.result_of(row)) for row in content["trials"]]
        except (ValueError, KeyError, TypeError, AttributeError):
            pass
        set_aside(path)
        self.warnings.append(f"{path}: is damaged; it is set aside and its trials run again.")
        return []

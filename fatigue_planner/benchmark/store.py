"""Finished trials on disk: small files, each published whole, from which a run goes on and a table is made.

`parts/<digest of the cell>/<first>-<last>.json` holds some trials of a cell and the SHA-256 of what
it says. Trials are keyed by cell and number, so it does not matter how a run cut them into parts.
"""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fatigue_planner.benchmark.grid import Cell
from fatigue_planner.benchmark.trial import Regret, TrialResult
from fatigue_planner.errors import DamagedFileError
from fatigue_planner.files import DIGEST_LENGTH, publish_sealed, read_sealed, set_aside


class TrialStore:
    """The finished trials below one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.warnings: list[str] = []

    def add(self, cell: Cell, results: Mapping[int, TrialResult]) -> None:
        """Keep some trials of a cell. Raises OutputFolderError if they cannot be written."""
        trials = [{"trial": trial, **asdict(results[trial])} for trial in sorted(results)]
        digest = cell.digest()
        content = {"cell": cell.name, "digest": digest, "trials": trials}
        publish_sealed(self._folder(digest) / f"{min(results)}-{max(results)}.json", content)

    def load(self, cell: Cell) -> dict[int, TrialResult]:
        """The finished trials of a cell, by number.

        A damaged part is set aside with a warning; two different results of one trial raise
        DamagedFileError, showing both.
        """
        found: dict[int, TrialResult] = {}
        digest = cell.digest()
        for path in sorted(self._folder(digest).glob("[0-9]*.json")):
            for number, result in self._read(path, digest).items():
                earlier = found.setdefault(number, result)
                if _outcome(earlier) != _outcome(result):
                    raise DamagedFileError(
                        f"{path}: trial {number} of {cell.name} has two results, {_outcome(earlier)} and "
                        f"{_outcome(result)}. Remove {path.parent} and run again."
                    )
        return found

    def _folder(self, digest: str) -> Path:
        return self.folder / digest[:DIGEST_LENGTH]

    def _read(self, path: Path, digest: str) -> dict[int, TrialResult]:
        content = read_sealed(path)
        try:
            if content is not None and content["digest"] == digest:
                return {int(row.pop("trial")): _result(row) for row in content["trials"]}
        except (ValueError, KeyError, TypeError, AttributeError):
            pass
        set_aside(path)
        self.warnings.append(f"{path}: is damaged; it is set aside and its trials run again.")
        return {}


def _result(row: Mapping[str, Any]) -> TrialResult:
    regret = row["regret"]
    return TrialResult(**{**row, "regret": None if regret is None else Regret(**regret)})


def _outcome(result: TrialResult) -> tuple[float, float, float]:
    """What must be equal when a trial is repeated; times never are."""
    return result.discounted_return, result.final_cost, result.peak_cost

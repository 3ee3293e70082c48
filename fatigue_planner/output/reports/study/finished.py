"""A finished sensitivity study, read back from its folder."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import BaseModel

from fatigue_planner.core.errors import DamagedFileError
from fatigue_planner.core.provenance import MANIFEST_FILE, Note, check_intact, read_note
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.reaction import digests
from fatigue_planner.study.sensitivity.settings import Headline, SpaceFilling

COMMAND = "fatplan sensitivity"
CONCLUSIONS_FILE = "lessons.txt"
FIGURES = "figures"
# Columns that are text even where all of it looks like numbers.
TEXTS = ("point", "condition", "planner", "baseline", "policy", "factor", "level", "least_at", "most_at")
# Keys that may differ between a study's base and the experiment of a report: a study has its own grid.
OF_THE_GRID = ("name", "benchmark", "statistics", "figures")


class NotedStudy(BaseModel):
    """The part of a study file that its page uses."""

    name: str
    baselines: tuple[str, ...]
    headline: Headline
    space_filling: SpaceFilling | None


class StudyNote(Note):
    """What `fatplan sensitivity` records: study and base experiment as plain values, seed, names of the figures."""

    study: NotedStudy
    experiment: dict[str, Any]
    seed: int
    figures: tuple[str, ...]


@dataclass(frozen=True)
class FinishedStudy:
    """The results of a study in a folder.

    conclusions: its sentences; tables: by the names in `sensitivity.tables`, without .csv.
    """

    folder: Path
    note: StudyNote
    conclusions: list[str]
    tables: dict[str, pd.DataFrame]

    @property
    def combines(self) -> bool:
        """Whether it changes all factors at once; else it sets a few points side by side."""
        return self.note.study.space_filling is not None

    def figure(self, name: str) -> tuple[str, pd.DataFrame]:
        """A figure's drawing (SVG) and its data."""
        path = self.folder / FIGURES / f"{name}.svg"
        return path.read_text(encoding="utf-8"), _table(path.with_suffix(".csv"))


def read_study(folder: Path) -> FinishedStudy:
    """The study in a folder. Raises DamagedFileError if its files are not as they were written."""
    note = read_note(folder, "sensitivity", StudyNote, COMMAND)
    for file in note.sha256:
        check_intact(folder, note, file, COMMAND)
    files = [Path(file) for file in note.sha256]
    tables = {file.stem: _table(folder / file) for file in files if file.suffix == ".csv" and len(file.parts) == 1}
    return FinishedStudy(folder, note, (folder / CONCLUSIONS_FILE).read_text(encoding="utf-8").splitlines(), tables)


def studies_of(experiment: Experiment, results: Path) -> list[FinishedStudy]:
    """The studies in a results folder whose base is this experiment, with the same reactions, by name.

    Raises DamagedFileError if its files are not as they were written.
    """
    found: list[FinishedStudy] = []
    now, reactions = experiment.plain(), set(digests(reaction_requests(experiment)).values())
    for manifest in sorted(results.glob(f"*/{MANIFEST_FILE}")):
        try:
            note = read_note(manifest.parent, "sensitivity", StudyNote, COMMAND)
        except DamagedFileError:
            continue  # results of another kind or version
        same = all(note.experiment.get(key) == now[key] for key in now if key not in OF_THE_GRID)
        if same and reactions <= set(note.reactions.values()):
            found.append(read_study(manifest.parent))
    return found


def _table(path: Path) -> pd.DataFrame:
    return pd.read_csv(path, dtype=dict.fromkeys(TEXTS, str), keep_default_na=False, na_values=[""])

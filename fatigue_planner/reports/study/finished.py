"""A finished sensitivity study, read back from its folder."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from fatigue_planner.errors import DamagedFileError
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.provenance import MANIFEST_FILE, check_intact, read_note
from fatigue_planner.sensitivity.settings import Headline

COMMAND = "fatplan sensitivity"
LESSONS_FILE = "lessons.txt"
FIGURES = "figures"
# What may differ between a study's base and the experiment a report is about: a study has a grid of its own.
OF_THE_GRID = ("name", "benchmark", "statistics", "figures")


@dataclass(frozen=True)
class FinishedStudy:
    """What a study left in a folder.

    lessons: its sentences; tables: by the names of `sensitivity.tables`, without .csv; figures: names in drawing order.
    """

    folder: Path
    note: dict[str, Any]
    lessons: list[str]
    tables: dict[str, pd.DataFrame]
    figures: list[str]

    @property
    def headline(self) -> Headline:
        """The comparison that its sentences and figures speak of."""
        return Headline.model_validate(self.note["study"]["headline"])

    @property
    def baselines(self) -> list[str]:
        """The policies that planners are compared with."""
        return list(self.note["study"]["baselines"])

    def svg(self, figure: str) -> str:
        """A figure's drawing."""
        return (self.folder / FIGURES / f"{figure}.svg").read_text(encoding="utf-8")

    def data(self, figure: str) -> pd.DataFrame:
        """A figure's data."""
        return pd.read_csv(self.folder / FIGURES / f"{figure}.csv", keep_default_na=False, na_values=[""])


def read_study(folder: Path) -> FinishedStudy:
    """The study in a folder. Raises DamagedFileError if its files are not what was written."""
    note = read_note(folder, "sensitivity", COMMAND)
    try:
        for file in note["sha256"]:
            check_intact(folder, note, file, COMMAND)
        files = [Path(file) for file in note["sha256"]]
        tables = {file.stem: _table(folder / file) for file in files if file.suffix == ".csv" and len(file.parts) == 1}
        figures = list(note["figures"])
        lessons = (folder / LESSONS_FILE).read_text(encoding="utf-8").splitlines()
    except (OSError, KeyError, ValueError) as error:
        raise DamagedFileError(f"{folder}: is not a whole study ({error}). Run `{COMMAND}`.") from error
    return FinishedStudy(folder, note, lessons, tables, figures)


def study_of(experiment: Experiment, results: Path) -> FinishedStudy | None:
    """The study in a results folder whose base is this experiment, if there is one. Raises DamagedFileError."""
    now = experiment.plain()
    for manifest in sorted(results.glob(f"*/{MANIFEST_FILE}")):
        try:
            note = read_note(manifest.parent, "sensitivity", COMMAND)
        except DamagedFileError:
            continue  # another kind of results
        base = note["experiment"]
        if all(base.get(key) == now[key] for key in now if key not in OF_THE_GRID):
            return read_study(manifest.parent)
    return None


def _table(path: Path) -> pd.DataFrame:
    return pd.read_csv(path, keep_default_na=False, na_values=[""])

"""Two results folders side by side."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import ValidationError

from fatigue_planner.core.errors import StaleTableError
from fatigue_planner.core.text import format_label, percent, percent_range, significant
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import Block, Section, Table, Text, as_text, page
from fatigue_planner.study.benchmark.results import BenchmarkNote, load_folder
from fatigue_planner.study.statistics.contrast import Contrast
from fatigue_planner.study.statistics.contrasts import side_by_side
from fatigue_planner.study.statistics.pairing import records

# These keys of the manifest decide no number.
IRRELEVANT = ("figures",)
MAX_NAMED = 5  # cells that are in one folder only
HEADER = ["condition", "cycles", "policy", "runs", "A", "B", "B above A", "interval", "p (Holm)"]
NOTHING = "No returns can be compared: no cell (condition, number of cycles and policy) is in both."


@dataclass(frozen=True)
class FolderComparison:
    """What tells two folders apart: settings and versions by dotted name, and the contrasts of their returns."""

    names: tuple[str, str]
    settings: dict[str, tuple[str, str]]
    versions: dict[str, tuple[str, str]]
    contrasts: pd.DataFrame
    only: tuple[list[str], list[str]]
    level: float
    same_worlds: bool

    @property
    def pairing(self) -> str:
        """How runs are paired, in words."""
        worlds = "with the same random numbers" if self.same_worlds else "the seeds differ, so the pairs are arbitrary"
        return f"paired by trial, {worlds}"


def compare(first: Path, second: Path) -> FolderComparison:
    """Compare the tables of two folders. Raises as `load_folder`."""
    (note, trials), (other_note, other_trials) = load_folder(first), load_folder(second)
    settings = _statistics(note, first)
    cells, other_cells = (_cells(table) for table in (trials, other_trials))
    return FolderComparison(
        names=(str(first), str(second)),
        settings=differences(flat(_relevant(note)), flat(_relevant(other_note))),
        versions=differences(note.versions, other_note.versions),
        contrasts=side_by_side(trials, other_trials, settings, note.seed),
        same_worlds=note.seed == other_note.seed,
        only=([c for c in cells if c not in other_cells], [c for c in other_cells if c not in cells]),
        level=settings.significance_level,
    )


def _cells(trials: pd.DataFrame) -> list[str]:
    names = trials["condition"] + "/" + trials["n_cycles"].astype(str) + "/" + trials["policy"]
    return list(dict.fromkeys(names))


def _statistics(note: BenchmarkNote, folder: Path) -> StatisticsSettings:
    try:
        return StatisticsSettings.model_validate(note.experiment.get("statistics"))
    except ValidationError as error:
        raise StaleTableError(
            f"{folder}: was made by another version of fatplan, without `statistics`. Run `fatplan benchmark` again."
        ) from error


def _relevant(note: BenchmarkNote) -> dict[str, Any]:
    return {key: value for key, value in note.experiment.items() if key not in IRRELEVANT}


def flat(value: Any, key: str = "") -> dict[str, str]:
    """The leaves of nested settings as text, by dotted key; what is listed and has parts of its own has its index."""
    if isinstance(value, dict) and value:
        parts = {f"{key}.{name}" if key else name: part for name, part in value.items()}
    elif isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        parts = {f"{key}[{index}]": item for index, item in enumerate(value)}
    elif isinstance(value, str):
        return {key: value}
    else:
        return {key: json.dumps(value, ensure_ascii=False) if value not in (None, {}, []) else "none"}
    return {name: text for path, part in parts.items() for name, text in flat(part, path).items()}


def differences(first: Mapping[str, str], second: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    """What differs between two sets of leaves, by key: in the first, in the second."""
    names = dict.fromkeys([*first, *second])
    both = {name: (first.get(name, "–"), second.get(name, "–")) for name in names}
    return {name: values for name, values in both.items() if values[0] != values[1]}


def compare_page(found: FolderComparison, figures: FigureFolder, name: str) -> str:
    """The comparison as a page (HTML); its table, if it has rows, goes to the figures' folder under this name."""
    file = None if found.contrasts.empty else figures.add_table(name, found.contrasts)
    return page("Two results side by side", " and ".join(found.names), [], _sections(found, file))


def compare_text(found: FolderComparison) -> str:
    """The comparison as lines of text."""
    return "\n\n".join(as_text(section) for section in _sections(found, None)) + "\n"


def _sections(found: FolderComparison, file: str | None) -> list[Section]:
    a, b = found.names
    returns: list[Block] = [Text(f"A is `{a}`, B is `{b}`.")]
    if found.contrasts.empty:
        returns.append(Text(NOTHING))
    else:
        level = percent(1 - found.level, 0)
        returns.append(Text(f"Runs are {found.pairing}; intervals are at {level}."))
        returns.append(Table("What B costs more than A, of A's cost.", HEADER, _rows(found), file))
    sections = [Section("Returns", returns)]
    for title, differences in (("Settings", found.settings), ("Versions", found.versions)):
        rows = [[name, *values] for name, values in differences.items()]
        block: Block = Table("What differs.", ["name", "A", "B"], rows) if rows else Text("They are the same.")
        sections.append(Section(title, [block]))
    alone = [Text(f"Only in {name}: {_few(cells)}.") for name, cells in zip("AB", found.only, strict=True) if cells]
    return [*sections, *([Section("In one of them only", alone)] if alone else [])]


def _few(cells: list[str]) -> str:
    more = len(cells) - MAX_NAMED
    return ", ".join(cells[:MAX_NAMED]) + (f" and {more} more" if more > 0 else "")


def _rows(found: FolderComparison) -> list[list[str]]:
    rows = []
    for row in records(found.contrasts):
        contrast = Contrast(**{key: value for key, value in row.items() if key != "policy"})
        cost = -contrast.first_mean or math.nan
        interval = percent_range(contrast.t_low / cost, contrast.t_high / cost)
        test = significant(contrast.holm_p, 2) if contrast.holm_p >= 0 else contrast.note
        if contrast.difference == 0 and not contrast.holm_p >= 0:
            interval, test = "", "the same in every run"
        rows.append(
            [
                format_label(contrast.condition), str(contrast.n_cycles), format_label(row["policy"]),
                str(contrast.trials),
                significant(contrast.first_mean, 6), significant(contrast.second_mean, 6),
                percent(contrast.difference / cost), interval,
                test,
            ]
        )  # fmt: skip
    return rows

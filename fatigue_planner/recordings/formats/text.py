"""Text files with tables of numbers: decoded, split into cells, and every number checked."""

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, listed, shortened

# Larger numbers are in no recording, whatever its unit; they would overflow later.
MAX_NUMBER = 1e9
MAX_COLUMNS = 20_000
_MISSING = re.compile(r"[-+]?(nan(\(.*\))?|1\.#(qnan|ind|snan)\d*)", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?")


def lines_of(content: bytes) -> list[str]:
    """The lines of a text file; UTF-8 or, if it is not, Latin 1. Raises RecordingError for one that is no text."""
    if b"\0" in content:
        raise RecordingError("is not a text file (it contains NUL).")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def cells_of(lines: Sequence[str], mark: str = ",") -> list[list[str]]:
    """The cells of every line of a CSV table, without blanks around them. Raises RecordingError."""
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=mark, strict=True)]
    except csv.Error as error:
        raise RecordingError(f"is not a table ({error}).") from error
    if len(rows) != len(lines):
        raise RecordingError("has cells of several lines.")
    return rows


def named_rows(path: Path, needed: Sequence[str], allowed: Sequence[str]) -> list[tuple[int, dict[str, str]]]:
    """The rows of a CSV table with these columns, and the line of each in the file. Raises RecordingError."""
    try:
        table = cells_of(lines_of(path.read_bytes()))
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror}).") from error
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error
    names = table[0] if table else []
    if set(needed) - set(names) or set(names) - {*needed, *allowed} or len(set(names)) < len(names):
        raise RecordingError(
            f"{path}, line 1: the columns are {listed(names) or 'none'}; required: {listed(needed)}; optional: "
            f"{listed(allowed)}."
        )
    rows = []
    for line, cells in enumerate(table[1:], 2):
        if not any(cells):
            continue
        if len(cells) != len(names):
            raise RecordingError(f"{path}, line {line}: has {len(cells)} cells; the table has {len(names)} columns.")
        rows.append((line, dict(zip(names, cells, strict=True))))
    if not rows:
        raise RecordingError(f"{path}: has no rows.")
    return rows


def refuse(line: int, problem: str) -> NoReturn:
    """Raise RecordingError with the number of a line, which is counted from 0 here."""
    raise RecordingError(f"line {line + 1}: {problem}")


def number(cell: str, line: int) -> float:
    """A number; NaN for a blank cell and all spellings of NaN. Raises RecordingError."""
    text = cell.strip()
    if not text or _MISSING.fullmatch(text):
        return math.nan
    if not _NUMBER.fullmatch(text):
        hint = "; write decimal points, not commas" if _NUMBER.fullmatch(text.replace(",", ".")) else ""
        refuse(line, f"{shortened(text)} is not a number{hint}.")
    value = float(text.translate(_EXPONENT))
    if abs(value) > MAX_NUMBER:
        refuse(line, f"{shortened(text)} is larger than any number of a recording.")
    return value


_EXPONENT = str.maketrans("dD", "ee")


def whole(text: str, what: str, line: int, least: int = 0) -> int:
    """A whole number. Raises RecordingError."""
    value = number(text, line)
    if not value >= least or value != int(value):
        refuse(line, f"{what} = {shortened(text)}: should be a whole number, at least {least}.")
    return int(value)


def table(rows: Sequence[Sequence[str]], first_line: int, columns: int) -> NDArray[np.float64]:
    """The numbers (rows, columns) of rows of cells; what a short row lacks, or a blank cell, is NaN.

    Raises RecordingError, naming the line, for a cell that is no number and for a row that is too long.
    """
    if columns > MAX_COLUMNS:
        refuse(first_line, f"{columns} columns, more than {MAX_COLUMNS}.")
    found = np.full((len(rows), columns), np.nan)
    for index, row in enumerate(rows):
        cells: Sequence[str] = row
        if len(cells) > columns:
            if any(cell.strip() for cell in cells[columns:]):
                refuse(first_line + index, f"{len(cells)} columns; the header names {columns}.")
            cells = cells[:columns]
        found[index, : len(cells)] = [number(cell, first_line + index) for cell in cells]
    return found

"""CSV: a table of markers (`LASI_x_mm`) or of angles (`elbow_flexion_deg`), with a column `time_s`."""

import re

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, listed
from fatigue_planner.recordings.content import Angles, Content, Points
from fatigue_planner.recordings.formats.text import cells_of, lines_of, refuse, table

Vector = NDArray[np.float64]
_POINT = re.compile(r"(.+)_([xyz])(?:_(mm|cm|m))?", re.IGNORECASE)
_ANGLE = re.compile(r"(.+)_(deg|rad)", re.IGNORECASE)
_LENGTH = re.compile(r"(.+)_(mm|cm|m)", re.IGNORECASE)
_TIMES = ("time_s", "time", "t")
_FACTOR = {"deg": np.pi / 180, "rad": 1.0}


def read_csv(content: bytes) -> Content:
    """The markers or angles of a CSV file; cells with commas, semicolons or tabs between them.

    Raises RecordingError, naming line or column.
    """
    lines = lines_of(content)
    while lines and not lines[-1].strip():
        lines.pop()
    if len(lines) < 2:
        raise RecordingError("has no rows.")
    mark = max(",;\t", key=lines[0].count)
    names, *rows = cells_of(lines, mark)
    if not names or names[0].lower() not in _TIMES:
        refuse(0, "the first column should be time_s.")
    if len(set(names)) < len(names) or not all(names):
        refuse(0, "columns have no name, or the same.")
    values = table(rows, 1, len(names))
    if np.isnan(values[:, 0]).any():
        refuse(1 + int(np.isnan(values[:, 0]).argmax()), "has no time.")
    column = dict(zip(names, values.T, strict=True))
    points = {name: found for name in names[1:] if (found := _POINT.fullmatch(name))}
    if not points:
        return _angles(names, column)
    if len(points) < len(names) - 1:
        refuse(0, f"these columns are no markers (name_x, _y, _z): {listed(n for n in names[1:] if n not in points)}.")
    units = {(found[3] or "").lower() for found in points.values()}
    if len(units) > 1:
        refuse(0, f"columns have different units: {listed(unit or 'none' for unit in sorted(units))}.")
    own = {(found[1], found[2].lower()): name for name, found in points.items()}
    if len(own) < len(points):
        refuse(0, "has several columns of one marker and axis.")
    labels = list(dict.fromkeys(label for label, _ in own))
    if missing := [f"{label}_{axis}" for label in labels for axis in "xyz" if (label, axis) not in own]:
        refuse(0, f"columns are missing: {listed(missing)}.")
    position = np.stack([[column[own[label, axis]] for axis in "xyz"] for label in labels])
    return Content(
        "CSV", values[:, 0], unit=units.pop() or None, points=Points(tuple(labels), position.transpose(2, 0, 1))
    )


def _angles(names: list[str], column: dict[str, Vector]) -> Content:
    found: dict[str, Vector] = {}
    lengths = set()
    units = set()
    for name in names[1:]:
        if angle := _ANGLE.fullmatch(name):
            found[angle[1]] = column[name] * _FACTOR[angle[2].lower()]
        elif length := _LENGTH.fullmatch(name):
            found[length[1]] = column[name]
            lengths.add(length[1])
            units.add(length[2].lower())
        else:
            refuse(0, f"{name}: should end in _x, _y or _z (a marker), or in _deg or _rad (an angle).")
    if len(units) > 1 or len(found) < len(names) - 1 or not found:
        refuse(0, "has columns of one name, of different units of length, or none.")
    angles = Angles(tuple(found), np.column_stack(list(found.values())), frozenset(lengths))
    return Content("CSV", column[names[0]], unit=units.pop() if units else None, angles=angles)

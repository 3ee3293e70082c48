"""TRC: markers as a table with tabs, the format of OpenSim and of Motion Analysis."""

import numpy as np

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.recordings.content import Content, Points, Remark
from fatigue_planner.recordings.formats.text import lines_of, number, refuse, table

HEADER_LINES = 5
TIME, FIRST = 1, 2  # columns: the first is the frame's number


def read_trc(content: bytes) -> Content:
    """The markers of a TRC file. Raises RecordingError, naming the line."""
    lines = lines_of(content)
    if not lines[0].lower().startswith("pathfiletype"):
        refuse(0, "should begin with PathFileType.")
    if len(lines) < HEADER_LINES:
        raise RecordingError(f"has {len(lines)} lines; the header of a TRC file has {HEADER_LINES}.")
    header = dict(zip(_cells(lines[1]), _cells(lines[2]), strict=False))
    names = _cells(lines[3])
    if not names[0].lower().startswith("frame") or len(names) <= TIME or not names[TIME].lower().startswith("time"):
        refuse(3, "should begin with Frame# and Time.")
    labels = tuple(name for name in names[FIRST:] if name)
    if not labels:
        refuse(3, "names no marker.")
    rows, numbers = [], []
    for index, line in enumerate(lines[HEADER_LINES:], HEADER_LINES):
        if line.strip():
            rows.append(line.split("\t"))
            numbers.append(index)
    if not rows:
        raise RecordingError("has no frames.")
    first = numbers[0]
    if numbers != list(range(first, first + len(numbers))):
        refuse(next(b for a, b in zip(range(first, len(lines)), numbers, strict=False) if a != b) - 1, "is blank.")
    values = table(rows, first, FIRST + 3 * len(labels))
    if np.isnan(values[:, TIME]).any():
        refuse(first + int(np.isnan(values[:, TIME]).argmax()), "has no time.")
    return Content(
        format="TRC",
        times_s=values[:, TIME],
        stated_rate_hz=number(header["DataRate"], 2) if header.get("DataRate") else None,
        unit=header.get("Units") or None,
        points=Points(labels, values[:, FIRST:].reshape(len(rows), -1, 3)),
        remarks=tuple(_remarks(header, len(labels), len(rows))),
    )


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split("\t")]


def _remarks(header: dict[str, str], markers: int, frames: int) -> list[Remark]:
    found = []
    for key, fault, count in (("NumMarkers", 4, markers), ("NumFrames", 14, frames)):
        stated = number(header.get(key, ""), 2)
        if stated != count:
            said = "is missing" if np.isnan(stated) else f"says {stated:g}"
            found.append(Remark(fault, f"{key} {said}; there are {count}."))
    return found

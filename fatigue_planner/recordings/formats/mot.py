"""MOT and STO: OpenSim's tables of coordinates or of forces on the ground."""

import re

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, listed, shortened
from fatigue_planner.recordings.content import Angles, Content, Plate
from fatigue_planner.recordings.formats.text import lines_of, refuse, table

MAX_HEADER_LINES = 200
_YES = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}
# ground_force_1_vx, 1_ground_force_px, ground_force_1_mx or 1_ground_torque_x: force, its point, and free moment.
_FORCE = re.compile(r"(.*)force(.*)_v([xyz])", re.IGNORECASE)
# Coordinates of these names are lengths: pelvis_tx and the like.
_LENGTH = re.compile(r"(.*_)?t[xyz]", re.IGNORECASE)


def read_mot(content: bytes, degrees: bool | None = None) -> Content:
    """The coordinates or the plates of a MOT or STO file; `degrees` says what the header leaves out.

    Raises RecordingError, naming the line or column, also if nothing says whether angles are in degrees.
    """
    lines = lines_of(content)
    end = next((i for i, line in enumerate(lines[:MAX_HEADER_LINES]) if line.strip().lower() == "endheader"), None)
    if end is None:
        raise RecordingError(f"has no line endheader among its first {MAX_HEADER_LINES}.")
    header = {
        key.strip().lower(): value.strip() for key, _, value in (line.partition("=") for line in lines[:end]) if value
    }
    start = next((i for i in range(end + 1, len(lines)) if lines[i].strip()), None)
    if start is None:
        refuse(end, "nothing follows the header.")
    names = lines[start].split()
    if names[0].lower() != "time":
        refuse(start, f"the first column is {shortened(names[0])}, not time.")
    if len(set(names)) < len(names):
        twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
        refuse(start, f"columns are named twice: {listed(twice)}.")
    body = lines[start + 1 :]
    while body and not body[-1].strip():
        body.pop()
    if not body:
        raise RecordingError("has no rows.")
    values = table([_cells(line) for line in body], start + 1, len(names))
    if np.isnan(values[:, 0]).any():
        refuse(start + 1 + int(np.isnan(values[:, 0]).argmax()), "has no time.")
    column = dict(zip(names, values.T, strict=True))
    plates, used = _plates(column)
    rest = [name for name in names[1:] if name not in used]
    times = values[:, 0]
    if not rest:
        return Content("MOT", times, plates=plates, plate_times_s=times)
    said = _YES.get(header.get("indegrees", "").lower(), degrees)
    if said is None:
        raise RecordingError("the header does not say whether angles are inDegrees; say it with --angles.")
    lengths = frozenset(name for name in rest if _LENGTH.fullmatch(name))
    factors = np.array([1.0 if name in lengths or not said else np.pi / 180 for name in rest])
    angles = Angles(tuple(rest), np.column_stack([column[name] for name in rest]) * factors, lengths)
    return Content("MOT", times, angles=angles, plates=plates, plate_times_s=times if plates else np.empty(0))


def _cells(line: str) -> list[str]:
    """The cells of a row: with tabs blank ones count, with spaces there are none."""
    return line.strip("\n").rstrip("\t ").split("\t") if "\t" in line.strip() else line.split()


def _plates(column: dict[str, NDArray[np.float64]]) -> tuple[tuple[Plate, ...], set[str]]:
    """The plates of a table's columns, and the columns they use. Raises RecordingError for one that is not whole."""
    stems = dict.fromkeys((m[1], m[2]) for name in column if (m := _FORCE.fullmatch(name)))
    plates, used = [], set()
    for before, after in stems:
        stem = f"{before}force{after}"
        moments = (f"{stem}_m", f"{before}torque{after}_", f"{before}moment{after}_")
        kind = next((m for m in moments if f"{m}x" in column), None)
        wanted = [f"{stem}_v{axis}" for axis in "xyz"] + [f"{stem}_p{axis}" for axis in "xyz"]
        wanted += [f"{kind}{axis}" for axis in "xyz"] if kind else []
        if missing := [name for name in wanted if name not in column]:
            raise RecordingError(f"a force has no columns {listed(missing)}.")
        force, point = (np.column_stack([column[name] for name in wanted[i : i + 3]]) for i in (0, 3))
        moment = np.column_stack([column[name] for name in wanted[6:]]) if kind else np.zeros_like(force)
        idle = np.asarray(~force.any(axis=1))  # where nothing presses, the point is nowhere
        plates.append(Plate(force, moment, np.where(idle[:, None], 0.0, point), unit="m"))
        used.update(wanted)
    return tuple(plates), used

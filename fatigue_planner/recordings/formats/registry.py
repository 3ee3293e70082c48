"""The formats of recordings: what a file's suffix stands for, and who reads it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from fatigue_planner.core.errors import RecordingError, listed
from fatigue_planner.recordings.content import Content
from fatigue_planner.recordings.formats.bvh import read_bvh
from fatigue_planner.recordings.formats.c3d import Reader, read_c3d
from fatigue_planner.recordings.formats.csv_table import read_csv
from fatigue_planner.recordings.formats.mot import read_mot
from fatigue_planner.recordings.formats.mvnx import read_mvnx
from fatigue_planner.recordings.formats.trc import read_trc

# An hour of 60 markers at 100 Hz as text has 500 MB.
MAX_FILE_BYTES = 500_000_000


@dataclass(frozen=True)
class Choices:
    """What only some formats ask: the library that reads C3D, and whether a table's angles are in degrees."""

    reader: Reader | None = None
    degrees: bool | None = None


FORMATS: dict[str, Callable[[bytes, Choices], Content]] = {
    ".c3d": lambda content, choices: read_c3d(content, choices.reader),
    ".trc": lambda content, _: read_trc(content),
    ".mot": lambda content, choices: read_mot(content, choices.degrees),
    ".sto": lambda content, choices: replace(read_mot(content, choices.degrees), format="STO"),
    ".bvh": lambda content, _: read_bvh(content),
    ".mvnx": lambda content, _: read_mvnx(content),
    ".csv": lambda content, _: read_csv(content),
}


def read_content(path: Path, choices: Choices | None = None) -> Content:
    """What a file says, by its suffix in upper or lower case.

    Raises RecordingError, which names the file, if it is none or cannot be read; MissingExtraError if a library is
    missing; ReaderError if the process that reads cannot be started.
    """
    read = FORMATS.get(path.suffix.lower())
    if read is None:
        raise RecordingError(f"{path}: is of no known format; known are {listed(FORMATS)}.")
    try:
        return read(_bytes(path), choices or Choices())
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error


def _bytes(path: Path) -> bytes:
    try:
        if not path.is_file():  # a pipe could make us wait for ever, and a device has no end
            raise RecordingError("is not a file." if path.exists() else "is not there.")
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        raise RecordingError(f"cannot be read ({getattr(error, 'strerror', None) or error}).") from error
    if len(content) > MAX_FILE_BYTES:
        raise RecordingError(f"is larger than {MAX_FILE_BYTES} bytes.")
    if not content:
        raise RecordingError("is empty.")
    return content

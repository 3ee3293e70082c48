"""Recordings, checked: read, interpreted, or refused with the reason."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.recordings.content import Content
from fatigue_planner.recordings.formats.registry import Choices, read_content
from fatigue_planner.recordings.inference.finding import Given
from fatigue_planner.recordings.inference.interpret import Interpreted, interpret


@dataclass(frozen=True)
class Checked:
    """A file, its format, what was found, or why it is refused."""

    file: Path
    format: str
    found: Interpreted | None
    refused: str = ""


def read_recording(*files: Path, given: Given | None = None, choices: Choices | None = None) -> tuple[str, Interpreted]:
    """The formats of files, and the recording they are: of one motion, with the plates of the others.

    Raises RecordingError, which names the file; MissingExtraError; ReaderError.
    """
    contents = [read_content(file, choices) for file in files]
    try:
        return " + ".join(one.format for one in contents), interpret(_joined(contents), given or Given())
    except RecordingError as error:
        raise RecordingError(f"{', '.join(map(str, files))}: {error}") from error


def _joined(contents: Sequence[Content]) -> Content:
    """The content that has a motion, or the first, with the plates of the others. Raises RecordingError."""
    motions = [one for one in contents if one.points or one.segments or one.angles]
    if len(motions) > 1:
        raise RecordingError("are several motions; a recording has one, and its plates in other files.")
    main = motions[0] if motions else contents[0]
    for other in contents:
        if other is not main:
            if main.plates:
                raise RecordingError("have plates in more than one file.")
            if abs(other.plate_times_s[0] - main.times_s[0]) > np.diff(main.times_s[:2], append=0.0).max() / 2:
                raise RecordingError(
                    f"begin at different times: {main.times_s[0]:g} s and, the plates, {other.plate_times_s[0]:g} s."
                )
            main = replace(main, plates=other.plates, plate_times_s=other.plate_times_s)
    return main


def check(files: Iterable[Path], given: Given, choices: Choices) -> list[Checked]:
    """All files, checked one by one. Raises MissingExtraError, ReaderError."""
    checked = []
    for file in files:
        try:
            checked.append(Checked(file, *read_recording(file, given=given, choices=choices)))
        except RecordingError as error:
            checked.append(Checked(file, "", None, str(error)))
    return checked

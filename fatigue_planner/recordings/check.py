"""Recordings, checked: read, interpreted, or refused with the reason."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.core.errors import RecordingError
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


def read_recording(file: Path, given: Given | None = None, choices: Choices | None = None) -> tuple[str, Interpreted]:
    """A file's format, and the recording it is.

    Raises RecordingError, which names the file; MissingExtraError; ReaderError.
    """
    content = read_content(file, choices)
    try:
        return content.format, interpret(content, given or Given())
    except RecordingError as error:
        raise RecordingError(f"{file}: {error}") from error


def check(files: Iterable[Path], given: Given, choices: Choices) -> list[Checked]:
    """All files, checked one by one. Raises MissingExtraError, ReaderError."""
    checked = []
    for file in files:
        try:
            checked.append(Checked(file, *read_recording(file, given, choices)))
        except RecordingError as error:
            checked.append(Checked(file, "", None, str(error)))
    return checked

"""What every result carries: configuration, versions, seed and hashes, without dates or machine."""

import hashlib
import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict

from fatigue_planner import __version__
from fatigue_planner.errors import DamagedFileError
from fatigue_planner.files import publish_text

MANIFEST_FILE = "manifest.json"
LIBRARIES = ("numpy", "scipy", "pandas", "numba", "pin", "casadi", "h5py", "matplotlib")


def versions() -> dict[str, str]:
    """Versions of this program, Python and the libraries that decide results."""
    return {"fatplan": __version__, "python": platform.python_version()} | {name: version(name) for name in LIBRARIES}


def publish_manifest(folder: Path, made_by: str, configuration: Mapping[str, Any], files: list[Path]) -> dict[str, str]:
    """Write the manifest: what made the files of a folder, from what, and their SHA-256, which are returned by name.

    Entries of other commands are kept, so one manifest describes the whole folder.
    """
    path = folder / MANIFEST_FILE
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        manifest = manifest if isinstance(manifest, dict) else {}
    except (OSError, ValueError):
        manifest = {}
    hashes = {file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
    manifest[made_by] = {"versions": versions(), **configuration, "sha256": hashes}
    publish_text(path, json.dumps(manifest, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n")
    return hashes


class Note(BaseModel):
    """What a command noted of the files it made in a folder."""

    model_config = ConfigDict(frozen=True)

    versions: dict[str, str]
    sha256: dict[str, str]
    reactions: dict[str, str]


N = TypeVar("N", bound=Note)


def read_note(folder: Path, made_by: str, kind: type[N], command: str) -> N:
    """The note of a command. Raises DamagedFileError if there is none, or none that this version understands."""
    path = folder / MANIFEST_FILE
    try:
        return kind.model_validate(json.loads(path.read_text(encoding="utf-8"))[made_by])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DamagedFileError(
            f"{path}: does not say, as this version does, how files were made. Run `{command}`."
        ) from error


def check_intact(folder: Path, note: Note, file: str, command: str) -> None:
    """Raise DamagedFileError unless a file is what was written when the note was made."""
    try:
        digest = hashlib.sha256((folder / file).read_bytes()).hexdigest()
    except OSError as error:
        raise DamagedFileError(f"{folder / file}: cannot be read ({error.strerror}). Run `{command}`.") from error
    if note.sha256.get(file) != digest:
        raise DamagedFileError(f"{folder / file}: is not what was written; it was altered or damaged. Run `{command}`.")

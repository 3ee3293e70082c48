"""What every result carries: configuration, versions, seed and hashes, without dates or machine."""

import hashlib
import json
import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict

from fatigue_planner import __version__
from fatigue_planner.errors import DamagedFileError
from fatigue_planner.files import publish_text, remove_left_behind, set_aside

MANIFEST_FILE = "manifest.json"
LIBRARIES = ("numpy", "scipy", "pandas", "numba", "pin", "casadi", "h5py", "matplotlib")


@cache
def versions_of(*libraries: str) -> dict[str, str]:
    """Versions of some libraries."""
    return {name: version(name) for name in libraries}


def versions() -> dict[str, str]:
    """Versions of this program, Python and the libraries that decide results."""
    return {"fatplan": __version__, "python": platform.python_version()} | versions_of(*LIBRARIES)


def publish_manifest(folder: Path, made_by: str, configuration: Mapping[str, Any], files: list[Path]) -> None:
    """Write the manifest: what made the files of a folder, from what, and their SHA-256.

    Entries of other commands are kept, so one manifest describes the whole folder; a damaged one is set aside. What
    killed runs have left behind in the folder is removed. Raises OutputFolderError; DamagedFileError if a file, just
    written, cannot be read.
    """
    path = folder / MANIFEST_FILE
    manifest = _read_manifest(path)
    hashes = {file.relative_to(folder).as_posix(): _sha256(file) for file in files}
    manifest[made_by] = {"versions": versions(), **configuration, "sha256": hashes}
    publish_text(path, json.dumps(manifest, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n")
    remove_left_behind(folder)


def _read_manifest(path: Path) -> dict[str, Any]:
    """What the other commands have noted; nothing if there is no manifest, or only a damaged one."""
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise DamagedFileError(f"{path}: cannot be read ({error.strerror}).") from error
    except ValueError:
        manifest = None
    if isinstance(manifest, dict):
        return manifest
    set_aside(path)
    return {}


def _sha256(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise DamagedFileError(f"{file}: cannot be read ({error.strerror}).") from error


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

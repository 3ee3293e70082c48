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
from fatigue_planner.core.errors import DamagedFileError
from fatigue_planner.core.files import canonical_json, digest_of, publish_text, remove_left_behind, set_aside

MANIFEST_FILE = "manifest.json"
SEAL = "seal"  # of a command's entry: the SHA-256 of all else it says
LIBRARIES = ("numpy", "scipy", "pandas", "numba", "pin", "casadi", "h5py", "matplotlib")


@cache
def versions_of(*libraries: str) -> dict[str, str]:
    """Versions of some libraries."""
    return {name: version(name) for name in libraries}


def versions() -> dict[str, str]:
    """Versions of this program, Python and the libraries that decide results."""
    return {"fatplan": __version__, "python": platform.python_version()} | versions_of(*LIBRARIES)


def publish_manifest(folder: Path, made_by: str, configuration: Mapping[str, Any], files: list[Path]) -> dict[str, str]:
    """Write the manifest: what made the files of a folder, from what, and their SHA-256, which are returned by name.

    Entries of other commands are kept, so one manifest describes the whole folder; each carries the SHA-256 of what it
    says. A damaged manifest is set aside. What killed runs have left behind in the folder is removed. Raises
    OutputFolderError; DamagedFileError if a file, just written, cannot be read.
    """
    path = folder / MANIFEST_FILE
    manifest = _read_manifest(path)
    hashes = {file.relative_to(folder).as_posix(): sha256(file) for file in files}
    entry = json.loads(canonical_json({"versions": versions(), **configuration, "sha256": hashes}))
    manifest[made_by] = {**entry, SEAL: digest_of(entry)}
    publish_text(path, _text(manifest))
    remove_left_behind(folder)
    return hashes


def _text(manifest: Mapping[str, Any]) -> str:
    return json.dumps(manifest, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n"


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


def sha256(file: Path, advice: str = "") -> str:
    """SHA-256, in hex, of a file. Raises DamagedFileError if it cannot be read."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        raise DamagedFileError(f"{file}: cannot be read ({error.strerror}).{advice}") from error


class Note(BaseModel):
    """What a command noted of the files it made in a folder."""

    model_config = ConfigDict(frozen=True)

    versions: dict[str, str]
    sha256: dict[str, str]
    reactions: dict[str, str]


def noted_files(folder: Path) -> dict[str, dict[str, str]]:
    """By command, the SHA-256 of the files it has noted in a folder, by name."""
    return {command: dict(entry["sha256"]) for command, entry in _read_manifest(folder / MANIFEST_FILE).items()}


N = TypeVar("N", bound=Note)


def read_note(folder: Path, made_by: str, kind: type[N], command: str) -> N:
    """The note of a command.

    Raises DamagedFileError if there is none, none that this version understands, or not the one that was written.
    """
    path = folder / MANIFEST_FILE
    try:
        text = path.read_text(encoding="utf-8")
        manifest = json.loads(text)
        entry = dict(manifest[made_by])
        seal = entry.pop(SEAL)
        note = kind.model_validate(entry)
        # the text, too, must be the one that was written: 1e-05 and 1E-05 are the same number
        intact = seal == digest_of(entry) and text == _text(manifest)
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise DamagedFileError(
            f"{path}: does not say, as this version does, how files were made. Run `{command}`."
        ) from error
    if not intact:
        raise DamagedFileError(f"{path}: is not what was written; it was altered or damaged. Run `{command}`.")
    return note


def check_intact(folder: Path, note: Note, file: str, command: str) -> None:
    """Raise DamagedFileError unless a file is what was written when the note was made."""
    if note.sha256.get(file) != sha256(folder / file, f" Run `{command}`."):
        raise DamagedFileError(f"{folder / file}: is not what was written; it was altered or damaged. Run `{command}`.")

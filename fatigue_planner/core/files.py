"""Files: published whole, found where they ship, and digests of what decides a result."""

import contextlib
import hashlib
import json
import os
import re
import secrets
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fatigue_planner.core.errors import ExperimentError, OutputFolderError, listed, shortened

if TYPE_CHECKING:
    import pandas as pd

PACKAGE = Path(__file__).parents[1]
DIGEST_LENGTH = 16  # hexadecimal digits of a digest in a file's name
# A temporary file of a run that is still going on is younger: it is written in one go.
LEFT_BEHIND_AFTER_S = 3600
# How a file that ships is named without folder and suffix.
_NAME = re.compile(r"\w{1,40}")
_TEMPORARY_MARK = "fatplan-unfinished-"
_TEMPORARY = re.compile(rf"\..*{_TEMPORARY_MARK}[0-9a-z_]+(\.\w+)?")


def shipped_folder() -> Path:
    """The folder of the experiments that ship with fatplan: the repository's, which the build puts into the wheel."""
    inside = PACKAGE / "shipped"
    return inside if inside.is_dir() else PACKAGE.parent / "experiments"


def find_shipped(path: Path) -> Path:
    """The file that is meant: itself or, where there is no such file, the one of this name that ships with fatplan.

    Raises ExperimentError, naming those that ship, if a bare name is none of them.
    """
    if not _NAME.fullmatch(str(path)) or path.is_file():
        return path
    shipped = shipped_folder() / f"{path}.yaml"
    if shipped.is_file():
        return shipped
    names = listed(file.stem for file in sorted(shipped_folder().glob("*.yaml")))
    raise ExperimentError(f"{path}: neither a file nor the name of one that ships with fatplan: {names}.")


def file_named_in(path: Path, key: str, named: str) -> Path:
    """The file that the file `path` names: relative to its folder or, where there is none, one that ships by its name.

    Raises ExperimentError with the file and its key if that is no file, or like `find_shipped`.
    """
    beside = path.parent / named
    if beside.is_file():
        return beside
    if not _NAME.fullmatch(named):
        raise ExperimentError(
            f"{path}: {key} = {shortened(named)}: there is no such file; a path is meant from the folder of this file."
        )
    try:
        return find_shipped(Path(named))
    except ExperimentError as error:
        raise ExperimentError(f"{path}: {key} = {error}") from None


def writable_folder(folder: Path) -> Path:
    """Create `folder` if need be and prove that a file can be written there.

    Raises OutputFolderError, naming the folder and the system's reason, if it cannot.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=f".{_TEMPORARY_MARK}"):
            pass
    except OSError as error:
        raise OutputFolderError(
            f"{folder}: cannot write there ({error.strerror}). Choose another folder or change its permissions."
        ) from error
    return folder


def publish(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file so that it appears under its name whole or not at all.

    `write` receives a temporary path in the same folder (with the same suffix); what it leaves there
    is flushed to the disk and renamed. A run that is killed leaves the temporary file, see `remove_left_behind`.
    Raises OutputFolderError if the folder cannot be written.
    """
    # the name is nobody else's, on no machine that shares the folder
    temporary = path.with_name(f".{path.stem}.{_TEMPORARY_MARK}{secrets.token_hex(8)}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write(temporary)
        with temporary.open("rb") as handle:
            os.fsync(handle.fileno())
        temporary.replace(path)
        _sync_folder(path.parent)
    except OSError as error:
        raise OutputFolderError(f"{path}: cannot be written ({error.strerror or error}).") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def left_behind(folder: Path) -> list[Path]:
    """Temporary files below a folder that a killed run has left, except those of runs that are still going on."""
    old = time.time() - LEFT_BEHIND_AFTER_S
    found = []
    for path in folder.rglob(f".*{_TEMPORARY_MARK}*"):
        with contextlib.suppress(FileNotFoundError):  # another run was faster
            if _TEMPORARY.fullmatch(path.name) and path.lstat().st_mtime < old:
                found.append(path)
    return sorted(found)


def remove_left_behind(folder: Path) -> None:
    """Remove what killed runs have left behind below a folder. Raises OutputFolderError if that cannot be done."""
    for path in left_behind(folder):
        remove(path)


def remove(path: Path) -> None:
    """Remove a file, if it is there. Raises OutputFolderError if that cannot be done."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise OutputFolderError(f"{path}: cannot be removed ({error.strerror}).") from error


def set_aside(path: Path) -> Path:
    """Rename a damaged file so that it is no longer read; its new path, which no other file had.

    Raises OutputFolderError if that cannot be done.
    """
    number = 1
    while (aside := path.with_suffix(f".damaged-{number}")).exists():
        number += 1
    try:
        with contextlib.suppress(FileNotFoundError):  # another run was faster
            path.replace(aside)
    except OSError as error:
        raise OutputFolderError(f"{path}: is damaged and cannot be set aside ({error.strerror}).") from error
    return aside


def publish_text(path: Path, text: str) -> None:
    """Publish a UTF-8 text file (see `publish`)."""
    publish(path, lambda temporary: temporary.write_text(text, encoding="utf-8", newline="\n"))


def publish_bytes(path: Path, content: bytes) -> None:
    """Publish a binary file (see `publish`)."""
    publish(path, lambda temporary: temporary.write_bytes(content))


def publish_csv(path: Path, table: "pd.DataFrame") -> None:
    """Publish a table without its index, the same bytes on every system (see `publish`)."""
    publish_text(path, table.to_csv(index=False, lineterminator="\n"))


def canonical_json(value: Any) -> str:
    """The one JSON text of a value: sorted keys, no blanks, shortest round-trip floats."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def publish_with_checksum(path: Path, content: Mapping[str, Any]) -> None:
    """Publish JSON values with the SHA-256 of what they say. Raises OutputFolderError if they cannot be written."""
    publish_text(path, _sealed(content))


def read_with_checksum(path: Path) -> dict[str, Any] | None:
    """What `publish_with_checksum` wrote, or None if the file is not exactly that."""
    try:
        text = path.read_text(encoding="utf-8")
        content: dict[str, Any] = json.loads(text)
        # the text, too, must be the one that was written: 1e-05 and 1E-05 are the same number
        intact = content.pop("sha256") == digest_of(content) and text == _sealed(content)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return content if intact else None


def _sealed(content: Mapping[str, Any]) -> str:
    return canonical_json({**content, "sha256": digest_of(content)})


def digest_of(value: Any) -> str:
    """SHA-256, in hex, of a JSON-like value."""
    return hashlib.sha256(canonical_json(value).encode()).hexdigest()


def digest_of_bytes(content: bytes) -> str:
    """SHA-256, in hex, of bytes."""
    return hashlib.sha256(content).hexdigest()


def digest_of_files(paths: Iterable[Path]) -> str:
    """SHA-256, in hex, of the names and bytes of files, in the order of their names."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


@cache
def digests_of_package(*parts: str) -> dict[str, str]:
    """SHA-256, in hex, of the source and data files of sub-packages and modules of fatigue_planner, by their path.

    `__init__.py` decides nothing: it says what a folder is.
    """
    below = [path for part in parts for path in (PACKAGE / part).rglob("*") if path.suffix in {".py", ".yaml"}]
    below = [path for path in below if path.name != "__init__.py"]
    found = [*below, *(PACKAGE / part for part in parts if part.endswith(".py"))]
    return {
        path.relative_to(PACKAGE).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(found)
    }


def digest_of_package(*parts: str) -> str:
    """SHA-256, in hex, of all of these files and their paths."""
    return digest_of(digests_of_package(*parts))

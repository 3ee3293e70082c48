"""An archive of reactions for another machine: a ZIP file, not compressed, of entries of the cache.

Nothing in an archive is believed: it is read from the front, entry by entry, sizes are checked before anything is read,
names are only compared, and every reaction is checked like one that was just simulated.
"""

import struct
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from fatigue_planner.core.errors import ArchiveError, DamagedFileError, OtherVersionError
from fatigue_planner.core.files import publish, publish_bytes, set_aside, writable_folder
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.hdf5_layout import MAX_BYTES, entry_bytes, read_entry
from fatigue_planner.reactions.reaction import ReactionRequest, file_name
from fatigue_planner.reactions.verify import faults_of

MAX_ENTRIES = 100_000
# The same bytes whenever and wherever it is made.
_EPOCH = (1980, 1, 1, 0, 0, 0)
# The header of an entry: mark, version, flags, method, time, date, CRC, stored and true size, length of the name
# and of further fields, which none of ours has.
_HEADER = struct.Struct("<4s5H3I2H")
_ENTRY_MARK, _END_MARKS = b"PK\3\4", (b"PK\1\2", b"PK\5\6")


@dataclass(frozen=True)
class Imported:
    """What became of an entry of an archive: where it is, and whether it is new there; or why it was refused."""

    member: str
    path: Path | None = None
    new: bool = False
    refused: str = ""


def export_archive(cache: ReactionCache, requests: Sequence[ReactionRequest], path: Path, how: str) -> int:
    """Publish an archive of reactions, each read and checked before; returns how many it holds.

    Raises as `ReactionCache.stream`, or OutputFolderError if the archive cannot be written.
    """
    unique = sorted({request.digest: request for request in requests}.values(), key=lambda request: request.name)

    def write(temporary: Path) -> None:
        with zipfile.ZipFile(temporary, "w") as archive:
            for reaction in cache.stored(unique, how):
                name = file_name(reaction.name, reaction.digest)
                archive.writestr(zipfile.ZipInfo(name, _EPOCH), entry_bytes(reaction))

    publish(path, write)
    return len(unique)


def import_archive(path: Path, cache: ReactionCache) -> Iterator[Imported]:
    """Check every entry of an archive and take the good ones into the cache, one by one.

    A damaged file under the name of a good one is set aside (see `ReactionCache.damaged`).
    Raises ArchiveError if the file is not an archive, OutputFolderError if the cache cannot be written.
    """
    for member, content in _entries(path):
        yield _take(member, content, cache)


def _entries(path: Path) -> Iterator[tuple[str, bytes]]:
    """Name and content of every entry, from the front to the list of contents, which is not read."""
    try:
        if not path.is_file() and path.exists():
            raise ArchiveError(f"{path}: is not a file.")
        with path.open("rb") as file:
            for _ in range(MAX_ENTRIES):
                entry = _next_entry(path, file)
                if entry is None:
                    return
                yield entry
            if _next_entry(path, file) is not None:
                raise ArchiveError(f"{path}: has more than {MAX_ENTRIES} entries; none of ours has.")
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be read ({error.strerror}).") from error


def _next_entry(path: Path, file: BinaryIO) -> tuple[str, bytes] | None:
    start = file.read(_HEADER.size)
    if start[:4] in _END_MARKS:
        return None
    if start[:4] != _ENTRY_MARK or len(start) < _HEADER.size:
        raise ArchiveError(f"{path}: is not an archive of reactions, or was cut off.")
    _, _, flags, method, _, _, _, stored, size, name_length, further = _HEADER.unpack(start)
    name = file.read(name_length).decode(errors="backslashreplace")
    if flags or method != zipfile.ZIP_STORED or stored != size or further:
        raise ArchiveError(f"{path}: {name!r} is not stored as `fatplan cache export` does: plainly.")
    if size > MAX_BYTES:
        raise ArchiveError(f"{path}: {name!r} has {size} bytes; none of ours has more than {MAX_BYTES}.")
    content = file.read(size)
    if len(content) < size:
        raise ArchiveError(f"{path}: was cut off in {name!r}.")
    return name, content


def _take(member: str, content: bytes, cache: ReactionCache) -> Imported:
    try:
        reaction = read_entry(content, repr(member))
    except (DamagedFileError, OtherVersionError) as error:
        return Imported(member, refused=str(error))
    own = file_name(reaction.name, reaction.digest)
    if member != own:
        return Imported(member, refused=f"{member!r}: holds another reaction than its name says, {own}.")
    if not reaction.key.is_current:
        return Imported(member, refused=f"{member!r}: was made by other sources or libraries.")
    faults = faults_of(reaction)
    if faults:
        return Imported(member, refused=f"{member!r}: {'; '.join(faults)}")
    path = cache.folder / own
    if path.exists():
        try:
            cache.read(path)
            return Imported(member, path)
        except (DamagedFileError, OtherVersionError) as error:
            cache.damaged.append(f"{error} It is set aside as {set_aside(path).name}.")
    publish_bytes(writable_folder(cache.folder) / own, content)
    return Imported(member, path, new=True)

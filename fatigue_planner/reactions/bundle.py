"""Reactions on their way to another machine: a ZIP file, not compressed, of entries of the cache.

Nothing in a bundle is believed: sizes are checked before anything is read, names are only compared, and every reaction
is checked like one that was just simulated.
"""

import struct
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.errors import BundleError, DamagedFileError, OtherVersionError
from fatigue_planner.files import publish, publish_bytes, writable_folder
from fatigue_planner.reactions.audit import faults_of
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.entry import MOST_BYTES, read_entry
from fatigue_planner.reactions.reaction import file_name

MOST_ENTRIES = 100_000
# The same bytes whenever and wherever it is made.
_EPOCH = (1980, 1, 1, 0, 0, 0)
# What Python's zipfile raises on a file that is none.
_UNREADABLE = (
    OSError, zipfile.BadZipFile, struct.error, ValueError, EOFError, NotImplementedError, RuntimeError, OverflowError,
)  # fmt: skip


@dataclass(frozen=True)
class Imported:
    """What became of an entry of a bundle: where it is, and whether it is new there; or why it was refused."""

    member: str
    path: Path | None = None
    new: bool = False
    refused: str = ""


def export_bundle(files: Sequence[Path], bundle: Path) -> None:
    """Publish a bundle of entries. Raises OutputFolderError if it cannot be written."""

    def write(temporary: Path) -> None:
        with zipfile.ZipFile(temporary, "w") as archive:
            for file in sorted(files):
                archive.writestr(zipfile.ZipInfo(file.name, _EPOCH), file.read_bytes())

    publish(bundle, write)


def import_bundle(bundle: Path, cache: ReactionCache) -> Iterator[Imported]:
    """Check every entry of a bundle and take the good ones into the cache, one by one.

    Raises BundleError if the file is no bundle, OutputFolderError if the cache cannot be written.
    """
    for member, content in _entries(bundle):
        yield _take(member, content, cache)


def _entries(bundle: Path) -> Iterator[tuple[str, bytes]]:
    try:
        with zipfile.ZipFile(bundle) as archive:
            members = archive.infolist()
            if len(members) > MOST_ENTRIES:
                raise BundleError(f"{bundle}: has {len(members)} entries; none of ours has more than {MOST_ENTRIES}.")
            if sum(member.file_size for member in members) > bundle.stat().st_size:
                raise BundleError(f"{bundle}: its entries are larger than itself; this is not one of ours.")
            for member in members:
                if member.compress_type != zipfile.ZIP_STORED:
                    raise BundleError(f"{bundle}: {member.filename!r} is compressed; this is not one of ours.")
                if member.file_size > MOST_BYTES:
                    raise BundleError(f"{bundle}: {member.filename!r} is larger than {MOST_BYTES} bytes.")
                yield member.filename, archive.read(member)
    except _UNREADABLE as error:
        raise BundleError(f"{bundle}: cannot be read as a bundle of reactions ({error}).") from error


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
    new = not path.exists()
    if new:
        publish_bytes(writable_folder(cache.folder) / own, content)
    return Imported(member, path, new)

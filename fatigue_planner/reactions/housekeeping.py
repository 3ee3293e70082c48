"""Files in the cache's folder that this program will never read again."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fatigue_planner.core.errors import DamagedFileError, OtherVersionError
from fatigue_planner.core.files import left_behind
from fatigue_planner.reactions.cache import ReactionCache, read_content
from fatigue_planner.reactions.cache_miss import Stored
from fatigue_planner.reactions.hdf5_layout import read_key


@dataclass(frozen=True)
class Useless:
    """A file that can go, why, and its size."""

    path: Path
    reason: str
    size_bytes: int


@dataclass(frozen=True)
class Contents:
    """What is in a cache: reactions this version finds, those of other versions, and what cannot be read, with why."""

    current: tuple[Stored, ...]
    other: tuple[Stored, ...]
    unreadable: tuple[tuple[Path, str], ...]
    damaged: tuple[tuple[Path, str], ...]


def contents(cache: ReactionCache, progress: Callable[[], None] = lambda: None) -> Contents:
    """Name and key of every entry of a cache; `progress` hears of each."""
    current: list[Stored] = []
    other: list[Stored] = []
    unreadable, damaged = [], []
    for path in cache.files():
        try:
            stored = Stored(path, *read_key(read_content(path), str(path)))
            (current if stored.key.is_current else other).append(stored)
        except OtherVersionError as error:
            unreadable.append((path, str(error)))
        except DamagedFileError as error:
            damaged.append((path, str(error)))
        progress()
    return Contents(tuple(current), tuple(other), tuple(unreadable), tuple(damaged))


def useless(cache: ReactionCache, found: Contents) -> list[Useless]:
    """Files that this program has made and will not read again; damaged ones are left to `simulate`, which says so."""
    reasons = {entry.path: "made by other sources or libraries" for entry in found.other}
    reasons |= {path: "of another format" for path, _ in found.unreadable}
    reasons |= dict.fromkeys(cache.folder.glob("*.damaged-*"), "was set aside as damaged")
    reasons |= dict.fromkeys(left_behind(cache.folder), "left behind by a run that was killed")
    return [Useless(path, reason, path.stat().st_size) for path, reason in sorted(reasons.items())]

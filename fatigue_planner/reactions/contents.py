"""What is in the cache: which reactions, why one is not found, and files that this program will never read again."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fatigue_planner.core.errors import DamagedFileError, OtherVersionError
from fatigue_planner.core.files import left_behind
from fatigue_planner.reactions.cache import ReactionCache, read_content
from fatigue_planner.reactions.hdf5_layout import read_key
from fatigue_planner.reactions.key import ReactionKey
from fatigue_planner.reactions.reaction import ReactionName, ReactionRequest


@dataclass(frozen=True)
class Stored:
    """A reaction in the cache, as far as its key goes."""

    path: Path
    name: ReactionName
    key: ReactionKey


@dataclass(frozen=True)
class Difference:
    """A part of a key that differs: what is wanted and what is stored, None where there is nothing."""

    part: str
    wanted: Any
    stored: Any


@dataclass(frozen=True)
class Miss:
    """A request that is not found, and in what the nearest stored reaction differs; None: nothing is stored at all."""

    name: ReactionName
    nearest: Stored | None
    differences: tuple[Difference, ...] = ()


def explain(request: ReactionRequest, stored: Sequence[Stored]) -> Miss:
    """Compare a request's key with the nearest: of the same name, if any, with the fewest parts that differ."""
    same_name = [entry for entry in stored if entry.name == request.name]
    candidates = [(entry, tuple(differences(request.key, entry.key))) for entry in same_name or stored]
    if not candidates:
        return Miss(request.name, None)
    nearest, found = min(candidates, key=lambda candidate: (len(candidate[1]), candidate[0].path.name))
    return Miss(request.name, nearest, found)


def differences(wanted: ReactionKey, stored: ReactionKey) -> Iterator[Difference]:
    """The parts in which two keys differ: settings by their path, sources by file, versions by library."""
    yield from _different("", wanted.settings, stored.settings)
    for kind, here, there in (
        ("source", wanted.sources, stored.sources),
        ("version of", wanted.versions, stored.versions),
    ):
        for name in sorted({*here, *there}):
            if here.get(name) != there.get(name):
                yield Difference(f"{kind} {name}", here.get(name), there.get(name))


def _different(path: str, wanted: Any, stored: Any) -> Iterator[Difference]:
    if isinstance(wanted, Mapping) and isinstance(stored, Mapping):
        for key in sorted({*wanted, *stored}):
            yield from _different(f"{path}.{key}" if path else str(key), wanted.get(key), stored.get(key))
    elif isinstance(wanted, list) and isinstance(stored, list) and len(wanted) == len(stored):
        for index, (ours, theirs) in enumerate(zip(wanted, stored, strict=True)):
            yield from _different(f"{path}.{index}", ours, theirs)
    elif wanted != stored:
        yield Difference(path, wanted, stored)


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

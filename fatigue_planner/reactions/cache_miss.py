"""Why a reaction is not found: which parts of its key differ from the nearest stored one."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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

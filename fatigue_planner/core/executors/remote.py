"""A piece of work on another machine: how it travels there and back, and what must be the same there as here."""

import os
import pickle
import platform
from collections.abc import Callable
from functools import cache
from typing import Any

from fatigue_planner.core.errors import ClusterError
from fatigue_planner.core.executors.executor import ONE_THREAD
from fatigue_planner.core.files import DIGEST_LENGTH, digest_of_package
from fatigue_planner.core.provenance import versions


@cache
def identity() -> dict[str, str]:
    """What decides results besides the work itself: this package's files, Python and the libraries."""
    return {"fatplan's files": digest_of_package("")[:DIGEST_LENGTH], **versions()}


def packed(work: Callable[[Any], Any], item: Any) -> bytes:
    """Work on an item as bytes: who unpickles them does it, and gets the result's pickle (see `unpacked`).

    So only the worker needs this package, not the scheduler, and what is sent is what processes of this machine are
    sent. There it raises ClusterError if that machine's fatplan is another or its linear algebra uses threads.
    """
    return pickle.dumps(_Call(identity(), pickle.dumps((work, item))))


def unpacked(result: bytes) -> Any:
    """What the work returned."""
    return pickle.loads(result)


class _Call:
    """Unpickled, it becomes what `_do` returns."""

    def __init__(self, expected: dict[str, str], payload: bytes) -> None:
        self._arguments = (expected, payload)

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return _do, self._arguments


def _do(expected: dict[str, str], payload: bytes) -> bytes:
    _check_same(expected, identity())
    work, item = pickle.loads(payload)
    return pickle.dumps(work(item))


def _check_same(expected: dict[str, str], here: dict[str, str]) -> None:
    """Raise ClusterError unless results of this process are those of the process that asks."""
    names = sorted(expected | here)
    differences = [f"{name} {here.get(name)} instead of {expected.get(name)}" for name in names
                   if here.get(name) != expected.get(name)]  # fmt: skip
    place = f"the worker on {platform.node()} (process {os.getpid()})"
    if differences:
        raise ClusterError(
            f"{place} has {', '.join(differences)}: its results could differ. Install the same fatplan and libraries "
            "on all machines (constraints.txt), and restart the workers."
        )
    threaded = [name for name in ONE_THREAD if os.environ.get(name) != "1"]
    if threaded:
        raise ClusterError(
            f"{place} was not started with {', '.join(f'{name}=1' for name in threaded)}: its results could differ. "
            "Start workers with a nanny, which sets them, or set them before."
        )

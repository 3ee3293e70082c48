"""Threads of one process, as a Dask worker has them, do not disturb each other."""

import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator
from hashlib import sha256
from pathlib import Path

import numba
import pytest

from fatigue_planner.core.jit import specialised
from fatigue_planner.planners.pomcp.leaf_values import problem_bound
from fatigue_planner.reactions.hdf5_layout import entry_bytes
from fatigue_planner.reactions.reaction import Reaction

PARTS = [numba.njit(eval(f"lambda x: x + {number}")) for number in range(40)]


@pytest.fixture
def hasty() -> Iterator[None]:
    """Threads take turns as often as they can."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval)


def in_threads(count: int, do: Callable[[int], object]) -> list[object]:
    """What each of some threads returns that begin at the same time."""
    gate, found = threading.Barrier(count), [None] * count

    def wait_and_do(number: int) -> None:
        gate.wait()
        found[number] = do(number)

    threads = [threading.Thread(target=wait_and_do, args=[number]) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return found


def test_kernels_made_in_threads_are_the_same_and_kept_in_one_place(hasty: None) -> None:
    before = numba.config.CACHE_DIR
    made = in_threads(8, lambda number: [specialised(problem_bound, bound=part) for part in PARTS])
    assert before == numba.config.CACHE_DIR
    assert all(kernels == made[0] for kernels in made)
    assert {Path(before)} == {Path(kernel._cache.cache_path).parents[1] for kernel in made[0]}


def test_a_reaction_has_the_same_bytes_whoever_looks_on(reactions: tuple[Reaction, ...], hasty: None) -> None:
    """A profiler, as a Dask worker has one, holds what functions have finished with a little longer."""
    expected = sha256(entry_bytes(reactions[0])).hexdigest()
    end, held = threading.Event(), deque[object](maxlen=50)

    def look_on() -> None:
        while not end.is_set():
            held.append(sys._current_frames())

    watcher = threading.Thread(target=look_on)
    watcher.start()
    try:
        assert {sha256(entry_bytes(reactions[0])).hexdigest() for _ in range(10)} == {expected}
    finally:
        end.set()
        watcher.join()

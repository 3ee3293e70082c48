"""Independent pieces of work, wherever they are done: on the cores of this machine or on a cluster.

What is written to disk is written by the process that asks, never by those that work: a worker may be anywhere, and
may be lost at any moment.
"""

from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, TypeVar

from fatigue_planner.core.interrupts import Interrupts

T = TypeVar("T")
R = TypeVar("R")

# Linear algebra on several threads may sum in another order. What the libraries read when they are loaded:
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
# A piece of work that was alone with its worker when that died, so many times, is given up: it is what kills them.
MAX_DEATHS = 3


@dataclass(frozen=True)
class Lost:
    """A piece of work that was given up; `reason` says why."""

    reason: str = f"its worker died {MAX_DEATHS} times, perhaps for want of memory"


@dataclass(frozen=True)
class Died:
    """What became of a piece of work whose worker died; `alone`: the worker had no other that it could have died of."""

    alone: bool


class Pool(ABC):
    """Workers that do one kind of work as long as the pool is open."""

    @property
    @abstractmethod
    def capacity(self) -> int:
        """How many pieces of work it takes at once to keep all workers busy; at least 1."""

    @property
    @abstractmethod
    def in_progress(self) -> int:
        """How many pieces of work are begun and not yet returned by `finished`."""

    @abstractmethod
    def submit(self, place: int, item: Any) -> None:
        """Begin a piece of work; `place` is its number."""

    @abstractmethod
    def finished(self) -> list[tuple[int, Any]]:
        """Wait until something is finished; the places and their results, or `Died`.

        Nothing at all means that `capacity` or `in_progress` may have changed. Raises what the work raised.
        """


class Executor(ABC):
    """Where work is done."""

    @property
    @abstractmethod
    def workers(self) -> int:
        """How many pieces of work are done at the same time."""

    @abstractmethod
    def pool(self, work: Callable[[Any], Any], most: int) -> AbstractContextManager[Pool]:
        """Open a pool of at most `most` workers that do `work`; what is still in progress at its end is dropped."""

    def run(self, work: Callable[[T], R], items: Sequence[T]) -> Iterator[tuple[int, R | Lost]]:
        """Do `work` on every item; yield (place of the item, result) as they come.

        A piece of work whose worker dies is done again; one of several that its worker may have died of is done
        alone, after all others. What was alone at MAX_DEATHS deaths is `Lost`. After an interrupt no more work is
        begun, the results of what is in progress are still yielded, and then it is raised (see `Interrupts`).
        """
        if not items:
            return
        deaths: Counter[int] = Counter()
        ready, suspects = deque(range(len(items))), deque[int]()
        pending: set[int] = set()
        with Interrupts() as interrupts, self.pool(work, len(items)) as pool:
            while pending or ready or suspects:
                while not interrupts.noted and _may_begin(ready, suspects, pending, pool.capacity):
                    place = (ready or suspects).popleft()
                    pending.add(place)
                    pool.submit(place, items[place])
                if interrupts.noted and not pool.in_progress:
                    break
                for place, result in pool.finished():
                    pending.discard(place)
                    if not isinstance(result, Died):
                        yield place, result
                        continue
                    deaths[place] += result.alone
                    if deaths[place] == MAX_DEATHS:
                        yield place, Lost()
                    else:
                        (ready if result.alone else suspects).append(place)


def _may_begin(ready: deque[int], suspects: deque[int], pending: set[int], capacity: int) -> bool:
    return len(pending) < capacity if ready else bool(suspects) and not pending

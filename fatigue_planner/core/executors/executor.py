"""Independent pieces of work, wherever they are done: on the cores of this machine or on a cluster.

What is written to disk is written by the process that asks, never by those that work: a worker may be anywhere, and
may be lost at any moment.
"""

import pickle
from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

import cloudpickle

from fatigue_planner.core.errors import FatplanError
from fatigue_planner.core.interrupts import Interrupts
from fatigue_planner.core.plugins import fault_of_plugin, load_files, loaded_files

T = TypeVar("T")
R = TypeVar("R")

# Linear algebra on several threads may sum in another order. What the libraries read when they are loaded:
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True)
class Lost:
    """A piece of work that was given up; `reason` says why."""

    reason: str


class WorkerDiedError(Exception):
    """The worker that did a piece of work died."""


class Pool(ABC):
    """Workers that do work as long as the pool is open."""

    # Work is given up after so many deaths of workers that did nothing else, with this reason.
    deaths_alone: ClassVar[int]
    given_up: ClassVar[str]

    @property
    @abstractmethod
    def capacity(self) -> int:
        """How many pieces of work keep all workers busy; 0 while there is no worker."""

    @abstractmethod
    def submit(self, payload: bytes) -> Any:
        """Begin a piece of work, as `perform` takes it; a future for `wait` and `result`."""

    @abstractmethod
    def wait(self, futures: Collection[Any]) -> Collection[Any]:
        """Wait until some futures are done and return these; none if only `capacity` may have changed."""

    @abstractmethod
    def result(self, future: Any) -> bytes:
        """What `perform` returned. Raises WorkerDiedError, or what the work raised."""


class Executor(ABC):
    """Where work is done."""

    @property
    @abstractmethod
    def workers(self) -> int:
        """How many pieces of work are done at the same time."""

    @abstractmethod
    def pool(self, most: int) -> AbstractContextManager[Pool]:
        """Open a pool of at most `most` workers; what is still in progress at its end is dropped."""

    def run(self, work: Callable[[T], R], items: Sequence[T]) -> Iterator[tuple[int, R | Lost]]:
        """Do `work` on every item; yield (index of the item, result) as they come.

        Work whose worker dies is done again after everything else, alone, which shows whether it is the culprit. After
        `Pool.deaths_alone` more deaths it is `Lost`. After an interrupt no more work is begun, the results of what is
        in progress are still yielded, and then the interrupt is raised (see `Interrupts`).
        """
        if not items:
            return
        ready, suspects = deque(range(len(items))), deque[int]()
        deaths: Counter[int] = Counter()
        pending: dict[Any, int] = {}
        with Interrupts() as interrupts, self.pool(len(items)) as pool:
            while pending or ready or suspects:
                while not interrupts.noted and _may_begin(ready, suspects, len(pending), pool.capacity):
                    index = (ready or suspects).popleft()
                    pending[pool.submit(_packed(work, items[index]))] = index
                if interrupts.noted and not (pending and pool.capacity):
                    break
                for future in sorted(pool.wait(pending), key=pending.__getitem__):
                    index = pending.pop(future)
                    try:
                        yield index, pickle.loads(pool.result(future))
                    except WorkerDiedError:
                        deaths[index] += 1
                        if deaths[index] > pool.deaths_alone:
                            yield index, Lost(pool.given_up)
                        else:
                            suspects.append(index)


def _may_begin(ready: deque[int], suspects: deque[int], pending: int, capacity: int) -> bool:
    return pending < capacity if ready else bool(suspects) and not pending and capacity > 0


def _packed(work: Callable[[Any], Any], item: Any) -> bytes:
    return pickle.dumps((loaded_files(), cloudpickle.dumps((work, item))))


def perform(payload: bytes) -> bytes:
    """Do packed work, in a worker: from a pickled function and its argument to the pickled result.

    Functions and classes of a script or a notebook are packed as code: no worker could import them. Plug-in files are
    loaded first. Raises what the function raises; PluginError if a plug-in fails.
    """
    plugins, packed = pickle.loads(payload)
    load_files(plugins)
    work, item = pickle.loads(packed)
    try:
        result = work(item)
    except FatplanError:
        raise
    except Exception as error:
        raise fault_of_plugin(error) or error from error
    return bytes(cloudpickle.dumps(result))

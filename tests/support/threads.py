"""Workers that share a process: what one thread does must not show in what another does."""

from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import Any

from fatigue_planner.core.executors.executor import Executor, Pool


class Threads(Executor):
    """So many threads of this process."""

    def __init__(self, count: int) -> None:
        self._count = count

    @property
    def workers(self) -> int:
        return self._count

    @contextmanager
    def pool(self, work: Callable[[Any], Any], most: int) -> Iterator[Pool]:
        with ThreadPoolExecutor(self._count) as executor:
            yield _ThreadPool(executor, work, self._count)


class _ThreadPool(Pool):
    def __init__(self, executor: ThreadPoolExecutor, work: Callable[[Any], Any], count: int) -> None:
        self._executor, self._work, self._count = executor, work, count
        self._places: dict[Future[Any], int] = {}

    @property
    def capacity(self) -> int:
        return self._count + 1

    @property
    def in_progress(self) -> int:
        return len(self._places)

    def submit(self, place: int, item: Any) -> None:
        self._places[self._executor.submit(self._work, item)] = place

    def finished(self) -> list[tuple[int, Any]]:
        done, _ = wait(self._places, return_when=FIRST_COMPLETED)
        return [(self._places.pop(future), future.result()) for future in done]

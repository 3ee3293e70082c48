"""Workers that share a process: what one thread does must not show in what another does."""

from collections.abc import Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager

from fatigue_planner.core.executors.executor import Executor, Pool, perform


class Threads(Executor):
    """So many threads of this process."""

    def __init__(self, count: int) -> None:
        self._count = count

    @property
    def workers(self) -> int:
        return self._count

    @contextmanager
    def pool(self, most: int) -> Iterator[Pool]:
        with ThreadPoolExecutor(self._count) as executor:
            yield _ThreadPool(executor, self._count)


class _ThreadPool(Pool):
    deaths_alone, given_up = 0, "a thread does not die"

    def __init__(self, executor: ThreadPoolExecutor, count: int) -> None:
        self._executor, self._count = executor, count

    @property
    def capacity(self) -> int:
        return self._count + 1

    def submit(self, payload: bytes) -> Future[bytes]:
        return self._executor.submit(perform, payload)

    def wait(self, futures: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        return wait(futures, return_when=FIRST_COMPLETED).done

    def result(self, future: Future[bytes]) -> bytes:
        return future.result()

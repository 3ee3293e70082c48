"""The cores of this machine: one process each."""

import os
import signal
import threading
from collections.abc import Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess

from fatigue_planner.core.executors.executor import ONE_THREAD, Executor, Pool, WorkerDiedError, perform


def available_cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class LocalProcesses(Executor):
    """Up to `jobs` processes.

    One item runs in its own process, too, and linear algebra uses one thread there, so that results do not depend on
    `jobs`.
    """

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs

    @property
    def workers(self) -> int:
        """See Executor.workers."""
        return self._jobs

    @contextmanager
    def pool(self, most: int) -> Iterator["_ProcessPool"]:
        """See Executor.pool."""
        os.environ |= dict.fromkeys(ONE_THREAD, "1")
        pool = _ProcessPool(min(self._jobs, most))
        try:
            yield pool
        finally:
            pool.close()


class _ProcessPool(Pool):
    deaths_alone = 3
    given_up = f"its worker died {deaths_alone} times while it did nothing else, perhaps for want of memory"

    def __init__(self, processes: int) -> None:
        self._processes = processes
        self._executor = self._new_executor()

    @property
    def capacity(self) -> int:
        """One more than there are processes, so that none waits for this one."""
        return self._processes + 1

    def submit(self, payload: bytes) -> Future[bytes]:
        """See Pool.submit."""
        try:
            with _interrupts_held():
                return self._executor.submit(perform, payload)
        except BrokenProcessPool as error:  # a process died between two pieces of work
            future: Future[bytes] = Future()
            future.set_exception(error)
            return future

    def wait(self, futures: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        """See Pool.wait. When a process dies, so do all: nobody knows which piece of work it was doing."""
        done = wait(futures, return_when=FIRST_COMPLETED).done
        if any(isinstance(future.exception(), BrokenProcessPool) for future in done):
            done = wait(futures).done
            self._executor.shutdown()
            self._executor = self._new_executor()
        return done

    def result(self, future: Future[bytes]) -> bytes:
        """See Pool.result."""
        try:
            return future.result()
        except BrokenProcessPool:
            raise WorkerDiedError from None

    def close(self) -> None:
        """Drop what has not begun and end the processes after what they are doing."""
        self._executor.shutdown(wait=True, cancel_futures=True)

    def _new_executor(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._processes, get_context("spawn"), _follow_the_parent)


def _follow_the_parent() -> None:
    """Do not outlive the parent if it is killed."""
    threading.Thread(target=_exit_after, args=[parent_process()], daemon=True).start()


def _exit_after(parent: BaseProcess | None) -> None:
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold SIGINT back for a moment; a process that is started meanwhile inherits that and never sees one."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

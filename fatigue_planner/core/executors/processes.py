"""The cores of this machine: one process each."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from typing import Any

from fatigue_planner.core.executors.executor import ONE_THREAD, Died, Executor, Pool


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
    def pool(self, work: Callable[[Any], Any], most: int) -> Iterator["_ProcessPool"]:
        """See Executor.pool."""
        os.environ |= dict.fromkeys(ONE_THREAD, "1")
        pool = _ProcessPool(work, min(self._jobs, most))
        try:
            yield pool
        finally:
            pool.close()


class _ProcessPool(Pool):
    def __init__(self, work: Callable[[Any], Any], processes: int) -> None:
        self._work = work
        self._processes = processes
        self._places: dict[Future[Any], int] = {}
        self._started = False
        self._executor = self._new_executor()

    @property
    def capacity(self) -> int:
        """One more than there are processes, so that none waits for this one."""
        return self._processes + 1

    @property
    def in_progress(self) -> int:
        """See Pool.in_progress."""
        return len(self._places)

    def submit(self, place: int, item: Any) -> None:
        """See Pool.submit."""
        try:
            # processes are started with the first piece of work, and inherit that, until they ignore SIGINT themselves
            with nullcontext() if self._started else _without_interrupts():
                future = self._executor.submit(self._work, item)
            self._started = True
        except BrokenProcessPool as error:  # a process died between two pieces of work; `finished` sees it
            future = Future()
            future.set_exception(error)
        self._places[future] = place

    def finished(self) -> list[tuple[int, Any]]:
        """See Pool.finished. When a process dies, so do all: nobody knows which piece of work it was doing."""
        done, _ = wait(self._places, return_when=FIRST_COMPLETED)
        alone = len(self._places) == 1
        if any(isinstance(future.exception(), BrokenProcessPool) for future in done):
            wait(self._places)
            done = set(self._places)
            self._executor.shutdown()
            self._started = False
            self._executor = self._new_executor()
        places = [(self._places.pop(future), future) for future in done]
        return [(place, _result(future, alone)) for place, future in sorted(places, key=lambda one: one[0])]

    def close(self) -> None:
        """Drop what has not begun and end the processes after what they are doing."""
        self._executor.shutdown(wait=True, cancel_futures=True)

    def _new_executor(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._processes, get_context("spawn"), _follow_the_parent)


def _result(future: Future[Any], alone: bool) -> Any:
    try:
        return future.result()
    except BrokenProcessPool:
        return Died(alone)


def _follow_the_parent() -> None:
    """Leave signals to the parent, and do not outlive it if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_after, args=[parent_process()], daemon=True).start()


def _exit_after(parent: BaseProcess | None) -> None:
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Ignore SIGINT for a moment; only a main thread can, and only there it arrives."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)

"""The cores of this machine: one process each."""

import atexit
import gc
import os
import signal
import sys
import threading
import weakref
from collections.abc import Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from multiprocessing.synchronize import Event
from tempfile import TemporaryFile
from types import ModuleType
from typing import IO

from fatigue_planner.core.errors import WorkerError
from fatigue_planner.core.executors.executor import ONE_THREAD, Executor, Pool, WorkerDiedError, perform

# Linear algebra on one thread; no file of the working folder is taken for a library.
_ENVIRONMENT = {**dict.fromkeys(ONE_THREAD, "1"), "PYTHONSAFEPATH": "1"}
_STDERR = 2


def available_cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class LocalProcesses(Executor):
    """Up to `jobs` processes, which stay for further work as long as this object is in use: a start takes seconds.

    One item runs in its own process, too, and linear algebra uses one thread there, so that results do not depend on
    `jobs`.
    """

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._idle: list[_ProcessPool] = []
        weakref.finalize(self, _close, self._idle)

    @property
    def workers(self) -> int:
        """See Executor.workers."""
        return self._jobs

    @contextmanager
    def pool(self, most: int) -> Iterator["_ProcessPool"]:
        """See Executor.pool. Raises WorkerError if no process can be started."""
        before = os.environ.copy()
        os.environ.update(_ENVIRONMENT)
        try:
            pool = self._idle.pop() if self._idle else _ProcessPool(self._jobs)
            try:
                yield pool
            except BaseException:
                pool.close()
                raise
            pool.show_said()
            self._idle.append(pool)
        finally:
            for name in _ENVIRONMENT:
                os.environ.pop(name)
            os.environ.update(before)


class _ProcessPool(Pool):
    deaths_alone = 3
    given_up = f"its worker died {deaths_alone} times while it did nothing else, perhaps for want of memory"

    def __init__(self, processes: int) -> None:
        self._processes = processes
        self._context = get_context("spawn")
        with _shared_memory():
            self._began = self._context.Event()
        self._executor = self._new_executor()
        self._said = TemporaryFile()  # noqa: SIM115 - `close` does

    @property
    def capacity(self) -> int:
        """One more than there are processes, so that none of them waits for work."""
        return self._processes + 1

    def submit(self, payload: bytes) -> Future[bytes]:
        """See Pool.submit. Raises WorkerError if no process can be started."""
        future: Future[bytes] = Future()
        try:
            with _starting(self._said):
                future = self._executor.submit(perform, payload)
        except (BrokenProcessPool, BrokenPipeError) as error:  # a process died between two pieces of work, or at once
            future.set_exception(BrokenProcessPool(str(error)))
        except OSError as error:
            raise WorkerError(f"a process that does the work cannot be started ({error.strerror}).") from error
        return future

    def wait(self, futures: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        """See Pool.wait. When a process dies, so do all: it is not known which piece of work it was doing."""
        done = wait(futures, return_when=FIRST_COMPLETED).done
        if any(isinstance(future.exception(), BrokenProcessPool) for future in done):
            done = wait(futures).done
            self._executor.shutdown()
            if not self._began.is_set():
                said = self._last_words().strip()
                raise WorkerError(f"a process ended before its first piece of work; it said:\n{said or 'nothing'}")
            self._executor = self._new_executor()
        return done

    def result(self, future: Future[bytes]) -> bytes:
        """See Pool.result."""
        try:
            return future.result()
        except BrokenProcessPool:
            raise WorkerDiedError from None

    def close(self) -> None:
        """Drop what has not begun, wait for the rest, end the processes and show what they printed on stderr."""
        self._executor.shutdown(wait=True, cancel_futures=True)
        self.show_said()
        self._said.close()

    def show_said(self) -> None:
        """Show what the processes have printed on stderr since the last time."""
        if said := self._last_words():
            sys.stderr.write(said)

    def _last_words(self) -> str:
        self._said.seek(0)
        said = self._said.read().decode(errors="replace")
        self._said.seek(0)  # where the processes go on writing, too
        self._said.truncate()
        return said

    def _new_executor(self) -> ProcessPoolExecutor:
        with _shared_memory():
            return ProcessPoolExecutor(self._processes, self._context, _begin, (self._began,))


def _close(pools: "list[_ProcessPool]") -> None:
    for pool in pools:
        pool.close()


def _begin(began: Event) -> None:
    """In a new process: say that it has begun, do not outlive the parent if that is killed, and end quickly."""
    began.set()
    atexit.register(gc.freeze)  # else Python looks through all it holds once more
    threading.Thread(target=_exit_after, args=[parent_process()], daemon=True).start()


def _exit_after(parent: BaseProcess | None) -> None:
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _shared_memory() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise WorkerError(
            f"/dev/shm: cannot be written ({error.strerror}). Processes share their locks there. Mount it writable "
            "(in a container as tmpfs), free some of it, or work on a cluster (--dask)."
        ) from error


@contextmanager
def _starting(said: IO[bytes]) -> Iterator[None]:
    """What a process that is started meanwhile inherits.

    SIGINT is blocked, so it never sees one. What it prints on stderr goes to the file `said`. It does not import the
    script that runs here, which would do everything once more: `perform` gets the script's functions as code.
    """
    signals = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    main, stderr = sys.modules["__main__"], os.dup(_STDERR)
    try:
        sys.modules["__main__"] = ModuleType("__main__")
        os.dup2(said.fileno(), _STDERR)
        yield
    finally:
        os.dup2(stderr, _STDERR)
        os.close(stderr)
        sys.modules["__main__"] = main
        signal.pthread_sigmask(signal.SIG_SETMASK, signals)

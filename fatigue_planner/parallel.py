"""Independent pieces of work on the cores of this machine."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.process import BaseProcess
from typing import TypeVar

from fatigue_planner.errors import LostWorkerError

T = TypeVar("T")
R = TypeVar("R")


def available_cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _follow_the_parent() -> None:
    """Leave signals to the parent, and do not outlive it if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_after, args=[parent_process()], daemon=True).start()


def _exit_after(parent: BaseProcess | None) -> None:
    if parent is not None:
        parent.join()
        os._exit(1)


def run_parallel(work: Callable[[T], R], items: Sequence[T], jobs: int) -> Iterator[tuple[int, R]]:
    """Do `work` on every item in up to `jobs` processes; yield (place of the item, result) as they come.

    One item runs in its own process, too, and linear algebra uses one thread there, so that results do
    not depend on `jobs`. If the consumer stops or fails, work not yet begun is cancelled and work in
    progress awaited.
    """
    if not items:
        return
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"
    with ProcessPoolExecutor(min(jobs, len(items)), get_context("spawn"), _follow_the_parent) as pool:
        with _without_interrupts():  # children being started inherit that, until they ignore SIGINT themselves
            futures = {pool.submit(work, item): place for place, item in enumerate(items)}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BrokenProcessPool as error:
            raise LostWorkerError(
                "a worker process was killed, perhaps for want of memory. What is finished is kept; run the same "
                "command again, with fewer --jobs if it recurs."
            ) from error
        except BaseException:
            print("Stopping after the work in progress (once more to stop at once) ...", file=sys.stderr)
            pool.shutdown(wait=True, cancel_futures=True)
            raise


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

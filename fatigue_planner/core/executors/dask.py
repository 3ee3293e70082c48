"""The workers of a Dask cluster, on any number of machines: Dask schedules, repeats and gives up the work."""

import gc
import logging
import os
import pickle
import platform
import re
import sys
import time
import warnings
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import version
from typing import Any

from distributed import Client, Future, KilledWorker, wait
from distributed.client import ClosedClientError
from distributed.versions import VersionMismatchWarning

from fatigue_planner.core.errors import ClusterError, LostClusterError
from fatigue_planner.core.executors.executor import ONE_THREAD, Executor, Pool, WorkerDiedError, perform
from fatigue_planner.core.files import DIGEST_LENGTH, digest_of_package
from fatigue_planner.core.provenance import versions

# How often to ask the scheduler how many threads its workers have.
LOOK_S = 2.0
# How long to wait for the first worker, or for another when all are gone: queues of clusters are long.
PATIENCE_S = 3600.0
# A scheduler that does not answer for so long is gone, even if its machine keeps the connection.
SILENCE_S = 120.0
_ADDRESS = re.compile(r"(tcp|tls)://([\w.-]+|\[[0-9a-fA-F:.%\w]+\]):\d{1,5}")
# Loggers that print on the terminal, with tracebacks, what is handled here.
_LOGGERS = ("distributed", "distributed.client", "tornado", "tornado.application", "asyncio")


class DaskCluster(Executor):
    """The workers that the scheduler at an address has, now and later.

    Raises ClusterError if it is not an address. `run` raises ClusterError if no scheduler answers there, if a
    worker has another fatplan or other libraries, or if no worker comes; LostClusterError if the scheduler is lost.
    """

    def __init__(self, address: str) -> None:
        if not _ADDRESS.fullmatch(address):
            raise ClusterError(
                f"--dask {address}: must be the address of a Dask scheduler, tcp://HOST:PORT or tls://HOST:PORT."
            )
        self._address = address

    @property
    def workers(self) -> int:
        """See Executor.workers: at this moment."""
        with self.pool(1) as pool:
            return max(1, pool.capacity)

    @contextmanager
    def pool(self, most: int) -> Iterator["_DaskPool"]:
        """See Executor.pool; the workers are those of the cluster, whatever `most` is."""
        with _silence():
            client = self._connect()
            try:
                yield _DaskPool(client, self._address)
            finally:
                with suppress(OSError):
                    client.close(2)  # not longer: it tries to find a scheduler that is gone

    def _connect(self) -> Client:
        # A client that could not connect is closed when it is collected: during the start of another one, for ever.
        gc.collect()
        try:
            return Client(self._address, set_as_default=False, name="fatplan")
        except (OSError, TypeError, ValueError, RuntimeError) as error:
            tls = " and that the certificates are right (distributed.comm.tls in Dask's configuration)"
            raise ClusterError(
                f"--dask {self._address}: cannot be reached ({' '.join(str(error).split())}). Check that "
                f"`dask scheduler` runs there{tls if self._address.startswith('tls') else ''}."
            ) from error


class _DaskPool(Pool):
    # Dask has counted before it gives a piece of work up: its configuration's `allowed-failures`.
    deaths_alone = 1
    given_up = "Dask gave it up twice (KilledWorker), the second time alone, perhaps for want of memory"

    def __init__(self, client: Client, address: str) -> None:
        self._client, self._address = client, address
        self._threads, self._looked, self._had_workers, self._said = 0, 0.0, time.monotonic(), False
        found = self._ask(client.scheduler.versions)["packages"]
        for name in ("dask", "distributed"):
            if found.get(name) != version(name):
                raise ClusterError(
                    f"{address}: the scheduler has {name} {found.get(name)} instead of {version(name)}. Install the "
                    "same on all machines (constraints.txt)."
                )
        self._look()
        client.subscribe_topic("all", _report_gone_worker)

    @property
    def capacity(self) -> int:
        """The threads of all workers: what waits for a thread would count as a death of its worker, too."""
        return self._threads

    def submit(self, payload: bytes) -> Future:
        """See Pool.submit."""
        with self._connected():
            return self._client.submit(pickle.loads, pickle.dumps(_RemoteCall(payload)), pure=False)

    def wait(self, futures: Collection[Future]) -> Collection[Future]:
        """See Pool.wait."""
        done: Collection[Future] = ()
        with self._connected(), self._client.as_current():
            if futures:
                with suppress(TimeoutError):
                    done = wait(list(futures), LOOK_S, "FIRST_COMPLETED").done
            else:
                time.sleep(LOOK_S)
        if not done or time.monotonic() - self._looked > LOOK_S:
            self._look()
        return done

    def result(self, future: Future) -> bytes:
        """See Pool.result."""
        try:
            if future.status == "error":
                raise future.exception()
            with self._connected():
                return bytes(future.result())
        except KilledWorker as error:
            raise WorkerDiedError from error
        except ImportError as error:
            if not (error.name or "").startswith("fatigue_planner"):
                raise
            raise ClusterError(
                f"a worker of {self._address} has no fatplan like this one ({error}). Install the same fatplan on all "
                "machines."
            ) from error

    def _look(self) -> None:
        """Ask how many threads the workers have. Raises ClusterError if there has been no worker for PATIENCE_S."""
        self._threads = sum(self._ask(self._client.scheduler.ncores, workers=None).values())
        self._looked = time.monotonic()
        alone_s = self._looked - self._had_workers
        if self._threads:
            self._had_workers, self._said = self._looked, False
        elif alone_s > PATIENCE_S:
            raise ClusterError(
                f"{self._address}: no worker for {PATIENCE_S / 60:.0f} minutes. Start workers (`dask worker "
                f"{self._address}`) and run the same command again; what is finished is kept."
            )
        elif alone_s > LOOK_S and not self._said:  # a nanny needs a moment to start a worker again
            self._said = True
            print(
                f"Waiting for a worker of {self._address} (at most {PATIENCE_S / 60:.0f} minutes) ...", file=sys.stderr
            )

    def _ask(self, question: Any, **arguments: Any) -> Any:
        with self._connected():
            return self._client.sync(question, **arguments, callback_timeout=SILENCE_S)

    @contextmanager
    def _connected(self) -> Iterator[None]:
        try:
            yield
        except (
            CancelledError,
            ClosedClientError,
            OSError,
        ) as error:  # Dask cancels all work then
            raise LostClusterError(
                f"{self._address}: the connection to the Dask scheduler is lost. What is finished is kept; the same "
                "command goes on from there, on this or another cluster or without --dask."
            ) from error


@cache
def _identity() -> dict[str, str]:
    """What decides results besides the work itself: this package's files, Python and the libraries."""
    return {"fatplan's files": digest_of_package("")[:DIGEST_LENGTH], **versions()}


class _RemoteCall:
    """Packed work (see `Pool.submit`) that is done where it is unpickled, which gives its packed result.

    Dask's scheduler unpickles functions, so it would need this package. It is sent `pickle.loads` and a pickled
    _RemoteCall instead. Unpickling raises ClusterError if fatplan, Python or a library is not the same there, or
    if linear algebra may use several threads.
    """

    def __init__(self, payload: bytes) -> None:
        self._arguments = (_identity(), payload)

    def __reduce__(self) -> tuple[Callable[..., bytes], tuple[Any, ...]]:
        return _perform_if_same, self._arguments


def _perform_if_same(expected: dict[str, str], payload: bytes) -> bytes:
    here = _identity()
    worker = f"the worker on {platform.node()} (process {os.getpid()})"
    different = [name for name in sorted(expected | here) if here.get(name) != expected.get(name)]
    if different:
        differences = ", ".join(f"{name} {here.get(name)} instead of {expected.get(name)}" for name in different)
        raise ClusterError(
            f"{worker} has {differences}: its results could differ. Install the same fatplan and libraries on all "
            "machines (constraints.txt), and restart the workers."
        )
    if threaded := [name for name in ONE_THREAD if os.environ.get(name) != "1"]:
        raise ClusterError(
            f"{worker} was not started with {', '.join(f'{name}=1' for name in threaded)}: its results could differ. "
            "Start workers with a nanny, which sets them, or set them before."
        )
    return perform(payload)


def _report_gone_worker(event: tuple[float, Any]) -> None:
    match event[1]:
        case {"action": "remove-worker", "expected": False, "worker": worker, "processing-tasks": tasks} if tasks:
            print(f"The worker {worker} is gone; Dask begins its work again.", file=sys.stderr)


@contextmanager
def _silence() -> Iterator[None]:
    """Keep Dask from printing what is handled here; versions that matter are compared on every worker."""
    warnings.filterwarnings("ignore", category=VersionMismatchWarning)
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)

"""The workers of a Dask cluster, on any number of machines."""

import asyncio
import logging
import re
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from distributed import Client
from distributed.versions import VersionMismatchWarning

from fatigue_planner.core.errors import ClusterError
from fatigue_planner.core.executors.crew import Crew, Raised
from fatigue_planner.core.executors.executor import Executor, Pool
from fatigue_planner.core.executors.remote import packed

_ADDRESS = re.compile(r"(tcp|tls)://([\w.-]+|\[[0-9a-fA-F:.%\w]+\]):\d{1,5}")
# Loggers that tell on the terminal, with tracebacks, what is handled here.
_LOGGERS = ("distributed", "distributed.client", "tornado", "tornado.application", "asyncio")
_GOODBYE_S = 2.0


class DaskCluster(Executor):
    """The workers that the scheduler at an address has, now and later.

    Raises ClusterError if it is no address. Opening a pool raises ClusterError if no scheduler answers there; its
    `finished` raises that if a worker's fatplan or libraries are others or if no worker comes, LostClusterError if the
    scheduler is gone.
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
        with self.pool(_nothing, 1) as pool:
            return pool.capacity

    @contextmanager
    def pool(self, work: Callable[[Any], Any], most: int) -> Iterator["_DaskPool"]:
        """See Executor.pool; the workers are those of the cluster, whatever `most` is."""
        pool = _DaskPool(self._address, work)
        with _silence():
            try:
                pool.open()
                yield pool
            finally:
                pool.close()


class _DaskPool(Pool):
    """Bridges the caller's thread and that of the event loop; `_news` guards what both use."""

    def __init__(self, address: str, work: Callable[[Any], Any]) -> None:
        self._address, self._work = address, work
        self._news = threading.Condition()
        self._results: list[tuple[int, Any]] = []
        self._notes: list[str] = []
        self._changed = False
        self._error: BaseException | None = None
        self._crew: Crew | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._leader: asyncio.Task[None] | None = None
        self._thread = threading.Thread(target=self._run, name="dask", daemon=True)

    @property
    def capacity(self) -> int:
        """The cluster's threads, at least 1: a first piece of work waits for the first worker."""
        return max(1, self._crew.threads) if self._crew else 1

    @property
    def in_progress(self) -> int:
        """See Pool.in_progress."""
        return len(self._results) + (self._crew.in_progress if self._crew else 0)

    def open(self) -> None:
        """Connect. Raises ClusterError."""
        self._thread.start()
        with self._news:
            self._news.wait_for(lambda: self._crew or self._error)
        if self._error is not None:
            raise self._error

    def submit(self, place: int, item: Any) -> None:
        """See Pool.submit."""
        payload = packed(self._work, item)
        assert self._loop is not None and self._crew is not None
        with suppress(RuntimeError):  # the loop has ended; `finished` says why
            self._loop.call_soon_threadsafe(self._crew.add, place, payload)

    def finished(self) -> list[tuple[int, Any]]:
        """See Pool.finished; also returns, with nothing, when there are other workers than before."""
        with self._news:
            self._news.wait_for(lambda: self._results or self._error or self._changed or self._notes)
            self._changed = False
            notes, self._notes = self._notes, []
            results, self._results = self._results, []
        for note in notes:
            print(note, file=sys.stderr)
        raised = [result.error for _, result in results if isinstance(result, Raised)]
        good = [(place, result) for place, result in results if not isinstance(result, Raised)]
        if raised:
            self._error = raised[0]
        if self._error is not None and not good:
            raise self._error
        return good

    def close(self) -> None:
        """Disconnect; workers finish what they are doing, and nobody takes it."""
        if self._loop is not None and self._leader is not None:
            with suppress(RuntimeError):  # the loop has ended by itself
                self._loop.call_soon_threadsafe(self._leader.cancel)
        if self._thread.ident is not None:
            self._thread.join(2 * _GOODBYE_S)

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except asyncio.CancelledError:
            pass
        except BaseException as error:
            with self._news:
                self._error = error
                self._news.notify()

    async def _serve(self) -> None:
        self._loop, self._leader = asyncio.get_running_loop(), asyncio.current_task()
        client = await self._connected()
        try:
            crew = Crew(client, self._take, self._hear_of_change, self._take_note)
            await crew.begin()
            with self._news:
                self._crew = crew
                self._news.notify()
            await crew.lead()
        finally:
            await _close(client)

    async def _connected(self) -> Client:
        client = Client(self._address, asynchronous=True, set_as_default=False, name="fatplan")
        try:
            return await client
        except (OSError, TypeError, ValueError, RuntimeError) as error:
            await _close(client)
            tls = " and that the certificates are right (distributed.comm.tls in Dask's configuration)"
            raise ClusterError(
                f"--dask {self._address}: cannot be reached ({' '.join(str(error).split())}). Check that "
                f"`dask scheduler` runs there{tls if self._address.startswith('tls') else ''}."
            ) from error

    def _take(self, place: int, result: Any) -> None:
        with self._news:
            self._results.append((place, result))
            self._news.notify()

    def _take_note(self, note: str) -> None:
        with self._news:
            self._notes.append(note)
            self._news.notify()

    def _hear_of_change(self) -> None:
        with self._news:
            self._changed = True
            self._news.notify()


async def _close(client: Client) -> None:
    with suppress(OSError, TimeoutError):  # if the scheduler is gone, it would try to find it again
        await asyncio.wait_for(client.close(), _GOODBYE_S)


def _nothing(_: Any) -> None:
    """No work."""


@contextmanager
def _silence() -> Iterator[None]:
    """Keep Dask from telling what is told here; versions that matter are compared on every worker."""
    levels = {name: logging.getLogger(name).level for name in _LOGGERS}
    for name in _LOGGERS:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    warnings.filterwarnings("ignore", category=VersionMismatchWarning)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)

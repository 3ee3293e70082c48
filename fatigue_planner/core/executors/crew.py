"""The workers of a Dask cluster and what each of them is doing, as a coroutine sees them.

Every piece of work is given to one worker of our choice, so that it is known who dies of what: Dask alone would give
the work of a dead worker to the next at once.
"""

import asyncio
import pickle
import time
import uuid
from collections import deque
from collections.abc import Callable
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from distributed import Client, Future, KilledWorker
from distributed.comm import CommClosedError
from distributed.scheduler import NoValidWorkerError

from fatigue_planner.core.errors import ClusterError, LostClusterError
from fatigue_planner.core.executors.executor import Died
from fatigue_planner.core.executors.remote import unpacked

# How often to look who is there; that somebody came or went is heard at once.
LOOK_S = 5.0
# How long to wait for the first worker, or for another when all are gone: queues of clusters are long.
PATIENCE_S = 3600.0
# A scheduler that does not answer for so long is gone, even if its machine keeps the connection.
SILENCE_S = 120.0


@dataclass(frozen=True)
class Raised:
    """The error that a piece of work raised."""

    error: Exception


@dataclass
class _Piece:
    place: int
    payload: bytes
    future: Future | None = None
    listener: "asyncio.Task[None] | None" = None


class Crew:
    """Pieces of work in, results out, whoever comes and goes; all methods but `in_progress` and `threads` in its loop.

    `report` hears of every result, `Died` or `Raised`; `changed` that there are other workers than before; `note` what
    the user may want to know.
    """

    def __init__(
        self,
        client: Client,
        report: Callable[[int, Any], None],
        changed: Callable[[], None],
        note: Callable[[str], None],
    ) -> None:
        self._client, self._report, self._changed, self._note = client, report, changed, note
        self._address = client.scheduler.address
        self._threads: dict[str, int] = {}  # of the workers that take more
        self._doing: dict[str, dict[str, _Piece]] = {}  # by worker and key
        self._waiting: deque[_Piece] = deque()
        self._removals = 0
        self._alone_since: float | None = None
        self._told = False
        self._wake, self._lost = asyncio.Event(), asyncio.Event()

    @property
    def threads(self) -> int:
        """How many pieces of work are done at the same time; 0 if nobody is there."""
        return sum(self._threads.values())

    @property
    def in_progress(self) -> int:
        """How many pieces of work some worker has."""
        return sum(map(len, list(self._doing.values())))

    def add(self, place: int, payload: bytes) -> None:
        """Take on a piece of work (see `remote.packed`)."""
        self._waiting.append(_Piece(place, payload))
        self._assign()

    async def begin(self) -> None:
        """Find out who is there. Raises LostClusterError, or ClusterError if the scheduler is of another version."""
        there = (await self._client.scheduler.versions())["packages"]
        for name in ("dask", "distributed"):
            if there.get(name) != version(name):
                raise ClusterError(
                    f"{self._address}: the scheduler has {name} {there.get(name)} instead of {version(name)}. Install "
                    "the same on all machines (constraints.txt)."
                )
        self._client.subscribe_topic("all", self._hear)
        await self._look_around()

    async def lead(self) -> None:
        """Follow who comes and goes, until cancelled.

        Raises LostClusterError if the scheduler is gone, ClusterError if no worker came for PATIENCE_S.
        """
        while True:
            with suppress(TimeoutError):
                await asyncio.wait_for(self._wake.wait(), LOOK_S)
            self._wake.clear()
            if self._lost.is_set():
                raise self._connection_lost()
            await self._look_around()

    def _connection_lost(self) -> LostClusterError:
        return LostClusterError(
            f"{self._address}: the connection to the Dask scheduler is lost. What is finished is kept; the same "
            "command goes on from there, on this or another cluster or without --dask."
        )

    async def _look_around(self) -> None:
        removals = None
        while removals != self._removals:  # else it may name a worker that was heard to be gone meanwhile
            removals = self._removals
            try:
                workers = (await asyncio.wait_for(self._client.scheduler.identity(), SILENCE_S))["workers"]
            except OSError as error:
                raise self._connection_lost() from error
        for address in self._doing.keys() - workers.keys():  # an event was missed
            self._remove(address, set(), orderly=True)
        self._threads = {address: one["nthreads"] for address, one in workers.items() if one["status"] == "running"}
        for address in self._threads:
            self._doing.setdefault(address, {})
        self._assign()
        self._changed()
        self._be_patient()

    def _be_patient(self) -> None:
        if self._threads or self.in_progress:
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since, self._told = time.monotonic(), False
        elif time.monotonic() - self._alone_since > PATIENCE_S:
            raise ClusterError(
                f"{self._address}: no worker for {PATIENCE_S / 60:.0f} minutes. Start workers (`dask worker "
                f"{self._address}`) and run the same command again; what is finished is kept."
            )
        elif not self._told and time.monotonic() - self._alone_since > LOOK_S / 2:  # a nanny needs a moment, too
            self._told = True
            self._note(f"Waiting for a worker of {self._address} (at most {PATIENCE_S / 60:.0f} minutes) ...")

    def _assign(self) -> None:
        while self._waiting:
            free = {address: threads - len(self._doing[address]) for address, threads in self._threads.items()}
            address = max(free, key=free.__getitem__, default=None)
            if address is None or free[address] <= 0:
                return
            piece, key = self._waiting.popleft(), f"fatplan-{uuid.uuid4().hex}"
            piece.future = self._client.submit(pickle.loads, piece.payload, key=key, workers=[address], pure=False)
            self._doing[address][key] = piece
            piece.listener = asyncio.create_task(self._listen(address, key, piece.future))

    async def _listen(self, address: str, key: str, future: Future) -> None:
        """Report what becomes of a piece of work; of its worker's death `_remove` does."""
        result: Any
        try:
            result = unpacked(await future)
        except (CancelledError, CommClosedError):  # Dask's, not that of this coroutine: the scheduler is gone
            self._lost.set()
            self._wake.set()
            return
        except KilledWorker:  # heard before the event, from a scheduler that allows few failures
            self._remove(address, set(self._doing[address]), orderly=False)
            return
        except NoValidWorkerError:
            self._waiting.append(self._doing[address].pop(key))
            self._wake.set()
            return
        except Exception as error:
            result = Raised(_explained(error, address))
        piece = self._doing[address].pop(key)
        self._report(piece.place, result)
        self._assign()

    def _hear(self, event: tuple[float, Any]) -> None:
        message = event[1]
        action = message.get("action") if isinstance(message, dict) else None
        if action == "add-worker":
            self._wake.set()
        elif action == "remove-worker":
            self._removals += 1
            # a worker that is told to go, by its nanny or by the scheduler, has not died of its work
            orderly = message["expected"] or str(message["stimulus_id"]).startswith("nanny-close")
            self._remove(message["worker"], set(message["processing-tasks"]), orderly)

    def _remove(self, address: str, processing: set[str], orderly: bool) -> None:
        """A worker is gone: report what it was doing; what it had not begun or had finished is given to another."""
        self._threads.pop(address, None)
        pieces = self._doing.pop(address, {})
        died = 0
        for key, piece in pieces.items():
            if piece.listener is not None and piece.listener is not asyncio.current_task():
                piece.listener.cancel()
            if piece.future is not None:
                piece.future.release()
            if key in processing and not orderly:
                died += 1
                self._report(piece.place, Died(alone=len(processing) == 1))
            else:
                self._waiting.append(_Piece(piece.place, piece.payload))
        if died:
            self._note(
                f"The worker {address} died; {'its' if died == 1 else f'its {died} pieces of'} work begins again."
            )
        self._wake.set()


def _explained(error: Exception, address: str) -> Exception:
    """The error of a piece of work, in words if it is that fatplan is missing there."""
    if isinstance(error, ImportError) and (error.name or "").startswith("fatigue_planner"):
        return ClusterError(
            f"the worker {address} has no fatplan like this one ({error}). Install the same fatplan on all machines."
        )
    return error

"""A session's journal: events are handed to a process that writes them, and what is durable is known afterwards."""

import json
import os
import queue
import subprocess
import sys
import threading
from collections import deque
from contextlib import ExitStack, suppress
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, Self

from fatigue_planner.core.errors import OutputFolderError
from fatigue_planner.core.text import counted
from fatigue_planner.live.events import Event
from fatigue_planner.live.journal_file import Stored, body_of, create, lock, pseudonyms, read_journal
from fatigue_planner.live.realtime import work_beside

# A process that was killed is started again so often; one whose commit has failed is not.
MAX_RESTARTS = 3
CLOSE_WAIT_S = 30.0


class Queued(NamedTuple):
    """What waits to be written: an event, what a worker's number stands for, or nothing, which ends the journal.

    number: of the last event before or of this one.
    """

    number: int
    row: tuple[Event, float, datetime | str] | None = None
    worker: list[str] | None = None

    @property
    def is_end(self) -> bool:
        """Whether nothing comes after it."""
        return self.row is None and self.worker is None

    def line(self) -> bytes:
        """As the process that writes reads it."""
        if self.row is None:
            return json.dumps({"worker": self.worker}).encode() + b"\n"
        event, seconds, utc = self.row
        utc = utc.isoformat() if isinstance(utc, datetime) else utc
        return json.dumps({"row": [self.number, seconds, utc, body_of(event)]}).encode() + b"\n"


class Journal:
    """The events of a shift: those found in the file, and those appended since.

    events: what the file had when it was opened. durable_up_to: the number of the last event that is on the disk, -1
    for none. fault: why nothing is recorded any more, "" as long as it is.
    """

    def __init__(self, path: Path) -> None:
        """Open a journal or make one.

        Raises JournalInUseError if it is open elsewhere, DamagedJournalError if it is not what was written,
        OtherVersionError, OutputFolderError if it cannot be written.
        """
        self.path = path
        self.fault, self.is_closed = "", False
        self._held = ExitStack()
        if not path.parent.is_dir():
            raise OutputFolderError(f"{path.parent}: there is no such folder.")
        try:
            self._lock = self._held.enter_context(lock(path))
            if not path.exists():
                create(path)
            self.events: list[Stored] = read_journal(path)
            self.workers = {pseudonym: random for random, pseudonym in pseudonyms(path).items()}
            self.durable_up_to = self._next = len(self.events) - 1
            self._restarts = 0
            self._process = self._start()
        except OSError as error:
            self._held.close()
            raise OutputFolderError(f"{path}: a journal cannot be written there ({error.strerror}).") from error
        except BaseException:
            self._held.close()
            raise
        self._handed_over: deque[tuple[int, bytes]] = deque()
        self._queue: queue.SimpleQueue[Queued] = queue.SimpleQueue()
        self._durable = threading.Condition()
        self._thread = threading.Thread(target=self._pump, name="fatplan journal", daemon=True)
        self._thread.start()

    def append(self, event: Event, seconds: float, utc: datetime | str) -> int:
        """Hand an event over and return its number at once; it is durable when `durable_up_to` has reached that.

        Its text is made in the journal's thread: no answer waits for that. After a fault it is only counted.
        """
        self._next += 1
        if not self.fault:
            self._queue.put(Queued(self._next, (event, seconds, utc)))
        return self._next

    def join(self, random: str, pseudonym: str) -> None:
        """Note which pseudonym a worker's random number stands for, in the table that can be erased."""
        self.workers[pseudonym] = random
        self._queue.put(Queued(self._next, worker=[random, pseudonym]))

    def wait(self, number: int, timeout_s: float) -> bool:
        """Wait until an event is durable; whether it is."""
        with self._durable:
            return self._durable.wait_for(lambda: self.durable_up_to >= number or self.fault != "", timeout_s) and (
                self.durable_up_to >= number
            )

    def close(self) -> None:
        """Write what was handed over and end the process that writes. Raises OutputFolderError if not all could be."""
        self.is_closed = True
        self._queue.put(Queued(self._next))
        self._thread.join(CLOSE_WAIT_S)
        self._held.close()
        if self.fault or self.durable_up_to < self._next:
            raise OutputFolderError(
                f"{self.path}: {counted(self._next - self.durable_up_to, 'event')} could not be recorded "
                f"({self.fault or 'the disk does not answer'}). Intact are those up to number {self.durable_up_to}."
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OutputFolderError) if error else ExitStack():
            self.close()

    def _start(self) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", "fatigue_planner.live.journal_process", os.fspath(self.path)]
        return subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, pass_fds=[self._lock], start_new_session=True
        )

    def _pump(self) -> None:
        """Hand over what has been queued, all that is there at a time, and wait until it is durable."""
        work_beside()
        running = self._acknowledged()
        while running:
            batch = [self._queue.get()]
            with suppress(queue.Empty):
                while True:
                    batch.append(self._queue.get_nowait())
            self._handed_over.extend((one.number, one.line()) for one in batch if not one.is_end)
            running = self._deliver() and not any(one.is_end for one in batch)
        self._end()

    def _deliver(self) -> bool:
        """Whether all that is handed over is on the disk now; a process that was killed is started again."""
        if not self._handed_over:
            return True
        assert self._process.stdin is not None
        while True:
            with suppress(BrokenPipeError, ValueError):
                self._process.stdin.write(b"".join(line for _, line in self._handed_over))
                self._process.stdin.flush()
            last = self._handed_over[-1][0]
            while self._acknowledged():
                if self.durable_up_to >= last:
                    self._handed_over.clear()
                    return True
            if self.fault:
                return False
            if self._restarts == MAX_RESTARTS:
                self._fail(f"the process that writes was ended {MAX_RESTARTS + 1} times")
                return False
            self._restarts += 1
            self._end()
            self._process = self._start()
            if not self._acknowledged():
                continue

    def _acknowledged(self) -> bool:
        """Read one reply; whether there was one that reports success."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            return False
        reply = json.loads(line)
        if "failed" in reply:
            self._fail(str(reply["failed"]))
            return False
        with self._durable:
            self.durable_up_to = max(self.durable_up_to, int(reply["durable"]))
            self._durable.notify_all()
        return True

    def _fail(self, why: str) -> None:
        with self._durable:
            self.fault = why
            self._durable.notify_all()

    def _end(self) -> None:
        """Let the process that writes come to its end."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()

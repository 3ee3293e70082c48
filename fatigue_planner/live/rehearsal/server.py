"""The server of a rehearsal: `fatplan live serve --rehearsal` as a process of its own, which may be killed."""

import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from fatigue_planner.core.errors import WorkerError
from fatigue_planner.live.clients.connection import Address

PAGE = re.compile(r"(http://127\.0\.0\.1:\d+)/#(\S+)\s*")
STOP_WAIT_S = 30.0


class Server:
    """A server that runs; `page`: the address of its page with the token to look."""

    def __init__(self, journal: Path, options: Sequence[str], rehearsal: bool = True) -> None:
        """Start it with these options of `fatplan live serve`. Raises WorkerError if it does not come up."""
        self.journal, self._options = journal, [*options, *(["--rehearsal"] if rehearsal else [])]
        self._port = 0
        self._messages: IO[str] = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115
        self.page = ""
        self._process = self._start()

    @property
    def address(self) -> Address:
        """Where clients find it, also after a restart."""
        return Address(f"http://127.0.0.1:{self._port}", self.journal.with_name(f"{self.journal.name}.act-token"))

    def kill(self) -> None:
        """SIGKILL: as when the machine's power fails, but for the disk's cache."""
        self._process.kill()
        self._process.wait()

    def restart(self) -> None:
        """Start it again, on the same port and journal. Raises WorkerError if it does not come up."""
        self._process = self._start()

    def close(self) -> None:
        """End it in good order."""
        if self._messages.closed:  # it did not come up again
            return
        self._process.terminate()
        try:
            self._process.wait(STOP_WAIT_S)
        except subprocess.TimeoutExpired:
            self.kill()
        self._messages.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _start(self) -> "subprocess.Popen[str]":
        command = [sys.executable, "-m", "fatigue_planner", "live", "serve", *self._options]
        command += ["--journal", str(self.journal), "--port", str(self._port)]
        self._messages.seek(0)
        self._messages.truncate()
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self._messages, text=True)
        assert process.stdout is not None
        with process.stdout:
            found = PAGE.fullmatch(process.stdout.readline())
        if found is None:
            process.kill()
            process.wait()
            self._messages.seek(0)
            said = self._messages.read().strip()[-500:]
            self._messages.close()
            raise WorkerError(f"the rehearsal's server did not start: {said}")
        self._port = int(found[1].rpartition(":")[2])
        self.page = found[0].strip()
        return process

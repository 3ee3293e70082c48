"""A process of its own that reads what may crash, hang or fill the process that asks.

It runs a script with the file descriptor of a connection. A request is two messages: JSON with `most_seconds` of CPU
time, and the content of a file. The answer is JSON, either `error` or `shapes`, and after it the bytes of every array.
A first message, empty, says that it is ready.
"""

import atexit
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import ReaderError

# Waited besides the CPU time, on a busy machine: for Python to start, and for content and numbers to be sent.
PATIENCE_S = 60
MAX_MESSAGE_LENGTH = 300
# No threads of linear algebra, whose memory would count; memory is given back.
_ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MALLOC_TRIM_THRESHOLD_": "1048576"}

Array = NDArray[Any]


class UnreadableError(Exception):
    """The content is not what it should be; the message, one printable line, says why."""


class _DiedError(Exception):
    """The reading process ended before it had answered; the argument is its exit code."""


class ReadingProcess:
    """The reading process, started when needed and again when a file has killed it; for one thread at a time."""

    def __init__(self, script: Path, what: str, environment: Mapping[str, str] | None = None) -> None:
        """`what` it reads is named where it cannot be started; what `environment` sets is set for it."""
        self._script, self._what, self._environment = script, what, dict(environment or {})
        self._begin()
        atexit.register(self.stop)
        os.register_at_fork(after_in_child=self._forget)

    def _begin(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None

    def read(self, content: bytes, request: Mapping[str, Any]) -> tuple[dict[str, Any], list[Array]]:
        """What the script answers, and its arrays.

        Raises UnreadableError if it says why it cannot, if it ends, or if it takes longer than `most_seconds`;
        ReaderError if the process cannot be started.
        """
        with self._lock:
            try:
                return self._ask(content, request)
            except _DiedError:
                pass
            # An earlier file may have damaged that process, or somebody killed it: only the end of a new one counts.
            try:
                return self._ask(content, request)
            except _DiedError as error:
                raise UnreadableError(f"ends the process that reads it ({error})") from error

    def stop(self) -> int | None:
        """End the process, if there is one; its exit code."""
        process, self._process = self._process, None
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        if process is None:
            return None
        try:
            return process.wait(1)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()

    def _forget(self) -> None:
        """In a fork of this process: the reading process, and the lock on it, belong to the parent."""
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self._process.returncode = 0  # nothing to be waited for
        self._begin()

    def _ask(self, content: bytes, request: Mapping[str, Any]) -> tuple[dict[str, Any], list[Array]]:
        connection = self._connection or self._start()
        try:
            connection.send_bytes(json.dumps(request).encode())
            connection.send_bytes(content)
            if not connection.poll(request["most_seconds"] + PATIENCE_S):
                raise UnreadableError("takes too long to read")
            answer = json.loads(connection.recv_bytes())
            arrays = [_array(connection, *shape) for shape in answer.get("shapes", [])]
        except (OSError, EOFError, ValueError) as error:
            code = self.stop()
            if code == -signal.SIGPROF:
                raise UnreadableError("takes too long to read") from error
            raise _DiedError(code) from error
        except BaseException:  # an interrupt, too: the next question must not get this one's answer
            self.stop()
            raise
        if "error" in answer:
            raise UnreadableError(_one_line(answer["error"]))
        return answer, arrays

    def _start(self) -> Connection:
        """Raises ReaderError if the process does not come up: that is no file's fault."""
        try:
            own, other = Pipe()
            with other:
                # -P: no file of the working folder is taken for a library; group: Ctrl-C is not meant for it
                self._process = subprocess.Popen(
                    [sys.executable, "-P", str(self._script), str(other.fileno())], pass_fds=[other.fileno()],
                    stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, process_group=0,
                    env={**os.environ, **_ENVIRONMENT, **self._environment},
                )  # fmt: skip
            self._connection = own
            if not own.poll(PATIENCE_S):
                raise TimeoutError("no answer")
            own.recv_bytes()
        except (OSError, EOFError) as error:
            code = self.stop()
            why = (getattr(error, "strerror", None) or str(error)) if code is None else f"exit code {code}"
            raise ReaderError(f"the process that reads {self._what} does not start ({why}).") from error
        except BaseException:
            self.stop()
            raise
        return own


def _array(connection: Connection, kind: str, shape: list[int]) -> Array:
    dtype = np.dtype(kind)
    size = int(np.prod(shape)) * dtype.itemsize
    return np.frombuffer(connection.recv_bytes(size), dtype).reshape(shape)


def _one_line(text: str) -> str:
    """A message that may repeat parts of the file, fit for a terminal."""
    return "".join(character if character.isprintable() else "?" for character in text[:MAX_MESSAGE_LENGTH])

"""The contents of HDF5 files, read by a process of its own: see `hdf5_reader`."""

import atexit
import json
import subprocess
import sys
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

SCRIPT = Path(__file__).with_name("hdf5_reader.py")
MOST_SECONDS = 60
# Python's own start and the sending of the numbers, on a busy machine.
PATIENCE_S = 30

Array = NDArray[Any]


class UnreadableError(Exception):
    """A content is not what it should be; the message says why."""


@dataclass(frozen=True)
class Layout:
    """What a file holds.

    datasets: name -> type ("f8", "i8", "S" for text) and shape, in which None stands for the number of rows
    most_rows: the most that any dataset has; most_text: the most bytes of a text
    """

    datasets: Mapping[str, tuple[str, tuple[int | None, ...]]]
    most_rows: int
    most_text: int


class _Reader:
    """The process that reads, started when it is needed and again when a file was its end."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None

    def read(self, content: bytes, request: Mapping[str, Any]) -> list[Array]:
        with self._lock:
            connection = self._connection or self._start()
            try:
                connection.send_bytes(json.dumps(request).encode())
                connection.send_bytes(content)
                if not connection.poll(request["most_seconds"] + PATIENCE_S):
                    raise TimeoutError
                answer = json.loads(connection.recv_bytes())
                if "error" in answer:
                    raise UnreadableError(answer["error"])
                return [_array(connection, *shape) for shape in answer["shapes"]]
            except UnreadableError:
                raise
            except TimeoutError as error:
                self.stop()
                raise UnreadableError("takes too long to read") from error
            except (OSError, EOFError) as error:
                code = self.stop()
                why = "takes too long to read" if code == -ALARM else f"ends the process that reads it ({code})"
                raise UnreadableError(why) from error

    def stop(self) -> int | None:
        """End the process; its exit code."""
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

    def _start(self) -> Connection:
        own, other = Pipe()
        # -P: no file of the working folder is taken for a library
        command = [sys.executable, "-P", str(SCRIPT), str(other.fileno())]
        with other:
            self._process = subprocess.Popen(
                command, pass_fds=[other.fileno()], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )  # fmt: skip
        self._connection = own
        return own


ALARM = 14  # the signal by which the reader ends itself
_READER = _Reader()
atexit.register(_READER.stop)


def read_hdf5(content: bytes, layout: Layout, most_seconds: int = MOST_SECONDS) -> dict[str, Array]:
    """The datasets of an HDF5 file's content, by name; what else is in it is not looked at.

    Raises UnreadableError if it is not of the layout, refers to other files, declares more than the layout allows, or
    makes HDF5 crash or go on for ever.
    """
    request = {
        "datasets": dict(layout.datasets), "most_rows": layout.most_rows, "most_text": layout.most_text,
        "most_seconds": most_seconds,
    }  # fmt: skip
    return dict(zip(layout.datasets, _READER.read(content, request), strict=True))


def _array(connection: Connection, kind: str, shape: list[int]) -> Array:
    dtype = np.dtype(kind)
    size = int(np.prod(shape)) * dtype.itemsize
    return np.frombuffer(connection.recv_bytes(size), dtype).reshape(shape)

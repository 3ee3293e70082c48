"""Reads HDF5 files in a process of its own, so that no file can crash, hang or fill the process that asks.

Run as a script with the file descriptor of a connection; it imports nothing of fatplan. A request is two messages: JSON
with `datasets`, the name, type and shape of everything to be read (a None in a shape stands for any number up to
`most_rows`, the same in all datasets that have one), and the content of the file. The answer is JSON, either `error` or
the shapes and, after it, the bytes of every dataset. A first message, empty, says that it is ready.

The file is never opened by its name: what it says of other files leads nowhere, and is refused before.
"""

import json
import math
import resource
import signal
import sys
from multiprocessing.connection import Connection
from typing import Any

import h5py
import numpy as np

# Address space: of Python and its libraries; for copies of the content; for copies of the numbers, once it is checked
# how many are declared. It stops what HDF5 does not check, such as a compressed piece that grows without end.
OWN_BYTES = 400 * 2**20
COPIES = 3
# What compresses and checks numbers; any other filter would be code from elsewhere.
FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32}
TYPES = {"f8": np.dtype("<f8"), "i8": np.dtype("<i8")}


class RefusedError(Exception):
    """The content is not what was asked for."""


def read(content: bytes, request: dict[str, Any]) -> list[np.ndarray[Any, Any]]:
    """The datasets that are asked for. Raises RefusedError, or whatever HDF5 raises."""
    wanted = request["datasets"]
    _limit_memory(len(content))
    with h5py.File.in_memory(content) as file:
        found = [_checked(file, name, kind) for name, (kind, _) in wanted.items()]
        rows: set[int] = set()
        for dataset, (name, (kind, shape)) in zip(found, wanted.items(), strict=True):
            _check_shape(dataset, name, shape, request["most_rows"], rows)
            if kind == "S" and dataset.dtype.itemsize > request["most_text"]:
                raise RefusedError(f"{name} is longer than {request['most_text']} bytes")
        if len(rows) > 1:
            raise RefusedError(f"its arrays have different lengths: {sorted(rows)}")
        _limit_memory(len(content) + sum(math.prod(dataset.shape) * dataset.dtype.itemsize for dataset in found))
        return [np.asarray(dataset[()]) for dataset in found]


def _limit_memory(size: int) -> None:
    most = OWN_BYTES + COPIES * size
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _checked(file: h5py.File, name: str, kind: str) -> h5py.Dataset:
    link = file.get(name, getlink=True)
    if not isinstance(link, h5py.HardLink):
        what = "is missing" if link is None else f"is a link elsewhere ({type(link).__name__})"
        raise RefusedError(f"{name} {what}")
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset):
        raise RefusedError(f"{name} is not a dataset")
    if dataset.external or dataset.is_virtual:
        raise RefusedError(f"{name} has its numbers in another file")
    if dataset.dtype.kind != "S" if kind == "S" else dataset.dtype != TYPES[kind]:
        raise RefusedError(f"{name} has numbers of type {dataset.dtype}")
    filters = dataset.id.get_create_plist()
    if any(filters.get_filter(index)[0] not in FILTERS for index in range(filters.get_nfilters())):
        raise RefusedError(f"{name} is packed by an unknown filter")
    return dataset


def _check_shape(dataset: h5py.Dataset, name: str, shape: list[int | None], most_rows: int, rows: set[int]) -> None:
    fits = dataset.shape is not None and len(dataset.shape) == len(shape)
    if not fits or any(asked not in (None, size) for asked, size in zip(shape, dataset.shape, strict=True)):
        raise RefusedError(f"{name} has the shape {dataset.shape}")
    if shape[:1] == [None] and dataset.shape[0] > most_rows:
        raise RefusedError(f"{name} has {dataset.shape[0]} rows, more than {most_rows}")
    if dataset.chunks is not None and math.prod(dataset.chunks) > 2 * max(math.prod(dataset.shape), 1):
        raise RefusedError(f"{name} is stored in pieces larger than itself")
    if shape[:1] == [None]:
        rows.add(dataset.shape[0])


def _answer(connection: Connection, content: bytes, request: dict[str, Any]) -> None:
    try:
        arrays = read(content, request)
    except RefusedError as refused:
        connection.send_bytes(json.dumps({"error": str(refused)}).encode())
    except Exception as error:  # HDF5 may raise anything on a damaged file
        text = f"cannot be read as HDF5 ({type(error).__name__}: {error})"
        connection.send_bytes(json.dumps({"error": text[:500]}).encode())
    else:
        shapes = [[array.dtype.str, array.shape] for array in arrays]
        connection.send_bytes(json.dumps({"shapes": shapes}).encode())
        for array in arrays:
            connection.send_bytes(array.tobytes())


def main(descriptor: int) -> None:
    """Answer requests until the other end is closed."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    connection = Connection(descriptor)
    connection.send_bytes(b"")
    while True:
        try:
            request = json.loads(connection.recv_bytes())
            content = connection.recv_bytes()
        except EOFError:
            return
        signal.setitimer(signal.ITIMER_PROF, request["most_seconds"])  # ends this process, whatever it computes
        _answer(connection, content, request)
        signal.setitimer(signal.ITIMER_PROF, 0)
        del content  # may be large, and the next request may be long in coming


if __name__ == "__main__":
    main(int(sys.argv[1]))

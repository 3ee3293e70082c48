"""A disk that fails at the i-th call: of write, fsync, rename, open, mkdir or unlink, below one folder."""

import errno
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

CALLS = ("open", "mkdir", "replace", "unlink")


class FailingDisk:
    """Counts the calls that change files below a folder; call number `fails_at` fails, or it and all after it."""

    def __init__(self, folder: Path, fails_at: int | None, number: int = errno.ENOSPC, for_good: bool = False) -> None:
        self.folder, self.fails_at, self.number, self.for_good = str(folder), fails_at, number, for_good
        self.calls: list[str] = []

    def call(self, name: str) -> bool:
        """Note a call; whether it fails."""
        self.calls.append(name)
        index = len(self.calls) - 1
        return self.fails_at is not None and (index == self.fails_at or (self.for_good and index > self.fails_at))

    def error(self, path: Any = None) -> OSError:
        return OSError(self.number, os.strerror(self.number), None if path is None else str(path))

    @property
    def failed(self) -> str:
        """The call that failed."""
        assert self.fails_at is not None
        return self.calls[self.fails_at]


class _File(io.FileIO):
    """A file that, when its disk fails, keeps half of what is written, as a full disk does."""

    def __init__(self, disk: FailingDisk, path: Any, mode: str) -> None:
        super().__init__(path, mode)
        self.disk = disk

    def write(self, data: Any) -> int:
        if self.disk.call("write"):
            super().write(bytes(data)[: len(data) // 2])
            raise self.disk.error()
        return super().write(data)


@contextmanager
def failing(disk: FailingDisk) -> Iterator[FailingDisk]:
    """Let calls of this process fail. HDF5 files are made in memory and written like all others."""
    real_open, real_fsync = io.open, os.fsync

    def is_ours(path: Any) -> bool:
        return isinstance(path, str | os.PathLike) and os.fspath(path).startswith(disk.folder)

    def opened(path: Any, mode: str = "r", *rest: Any, **options: Any) -> Any:
        if not is_ours(path) or not set(mode) & set("wxa+"):
            return real_open(path, mode, *rest, **options)
        if disk.call("open"):
            raise disk.error(path)
        if "opener" in options:  # a temporary file that only proves the folder
            return real_open(path, mode, *rest, **options)
        buffered = io.BufferedWriter(_File(disk, path, mode.replace("b", "").replace("t", "")))
        if "b" in mode:
            return buffered
        return io.TextIOWrapper(buffered, encoding=options.get("encoding"), newline=options.get("newline"))

    def synced(descriptor: int) -> None:
        if disk.call("fsync"):
            raise disk.error()
        real_fsync(descriptor)

    def guarded(name: str) -> Any:
        real = getattr(os, name)

        def call(path: Any, *rest: Any, **options: Any) -> Any:
            idle = name == "mkdir" and Path(path).exists()  # whatever the disk is like, it says that it exists
            idle |= name == "open" and Path(path).is_file() and not rest[0] & (os.O_WRONLY | os.O_RDWR)  # is only read
            if is_ours(path) and not idle and disk.call(name):
                raise disk.error(path)
            return real(path, *rest, **options)

        return call

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(io, "open", opened)
        patch.setattr(os, "fsync", synced)
        for name in CALLS:
            patch.setattr(os, name, guarded(name))
        yield disk

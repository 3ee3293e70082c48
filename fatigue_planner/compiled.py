"""Compilation of numeric kernels by numba, cached on disk without ever running stale code.

Numba's own cache looks at one source file only and misses a changed callee in another. Here the
cache folder carries the digest of every source of the package and of numba's version, so a change
anywhere starts a fresh one.
"""

import os
import tempfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

import numba

from fatigue_planner.errors import OutputFolderError
from fatigue_planner.files import DIGEST_LENGTH, PACKAGE, digest_of, digest_of_files, writable_folder

F = TypeVar("F", bound=Callable[..., Any])


def cache_folder() -> Path:
    """Folder of the compiled kernels of these sources: the user's cache, or a temporary one if it must be."""
    key = digest_of([digest_of_files(PACKAGE.rglob("*.py")), version("numba")])[:DIGEST_LENGTH]
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fatplan" / key
    try:
        return writable_folder(folder)
    except OutputFolderError:
        return Path(tempfile.gettempdir()) / f"fatplan-{os.getuid()}" / key


numba.config.CACHE_DIR = str(cache_folder())


def compiled(function: F) -> F:
    """Compile a function to machine code that releases Python's lock; division by zero gives inf."""
    decorated: F = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    return decorated

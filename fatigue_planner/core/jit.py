"""Compilation of numeric kernels by numba, cached on disk without ever running stale code.

Numba's own cache looks at one source file only and misses a changed callee in another. Here the
cache folder carries the digest of every source of the package and of numba's version, so a change
anywhere starts a fresh one. A kernel that calls functions from outside the package (see `specialised`)
is kept in a folder that carries the digest of their code, too; such functions themselves are not kept.
"""

import atexit
import copyreg
import hashlib
import os
import shutil
import stat
import sys
import tempfile
import threading
from collections.abc import Callable, Hashable, Sequence
from enum import Enum
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

import numba
import numpy as np
from numba.core.registry import CPUDispatcher

from fatigue_planner.core.errors import OutputFolderError
from fatigue_planner.core.files import DIGEST_LENGTH, PACKAGE, digest_of, digest_of_files, writable_folder

F = TypeVar("F", bound=Callable[..., Any])

# Variable of the environment with the folder that a program made for itself and for the processes it starts.
PRIVATE_FOLDER = "FATPLAN_PRIVATE_KERNELS"
# Numba's cache folder is a setting of all threads, so only one of them at a time compiles.
_making = threading.RLock()


@cache
def cache_folder() -> Path:
    """Folder of the compiled kernels of these sources: in the user's cache, else in the temporary folder.

    Numba runs what lies there, so nobody else may be able to write there. If that is so in neither, it is a private
    folder for this program and the processes it starts, and one line on stderr says so.
    """
    if private := os.environ.get(PRIVATE_FOLDER):
        return Path(private)
    key = digest_of([digest_of_files(PACKAGE.rglob("*.py")), version("numba")])[:DIGEST_LENGTH]
    reasons = []
    for parent in (_user_cache, lambda: Path(tempfile.gettempdir()) / f"fatplan-{os.getuid()}"):
        try:
            return _closed_folder(parent(), key)
        except (OSError, OutputFolderError) as error:
            reasons.append(str(error).partition("\n")[0].rstrip("."))
    made = Path(tempfile.mkdtemp(prefix="fatplan-"))
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    os.environ[PRIVATE_FOLDER] = str(made)
    print(f"Compiled kernels are kept in {made} only until this program ends: {'; '.join(reasons)}.", file=sys.stderr)
    return made


def _user_cache() -> Path:
    if given := os.environ.get("XDG_CACHE_HOME"):
        return Path(given) / "fatplan"
    try:
        return Path.home() / ".cache" / "fatplan"
    except RuntimeError as error:
        raise OutputFolderError("there is no home folder") from error


def _closed_folder(parent: Path, name: str) -> Path:
    """A folder in `parent` that nobody else can write to, nor to `parent`. Raises OSError, OutputFolderError."""
    parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    folder = parent / name
    folder.mkdir(mode=0o700, exist_ok=True)
    for path in (parent, folder):
        if {path.lstat().st_uid, path.stat().st_uid} != {os.getuid()}:
            raise OutputFolderError(f"{path} is somebody else's")
        if path.stat().st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            raise OutputFolderError(f"{path} can be written by others (chmod go-w)")
    return writable_folder(folder)


numba.config.CACHE_DIR = str(cache_folder())


def compiled(function: F) -> F:
    """Compile a function to machine code that releases Python's lock; division by zero gives inf.

    >>> @fp.compiled
    ... def half(x):
    ...     return x / 2
    >>> half(3)
    1.5
    """
    return _compiled(function, {})


def kernel(function: F) -> F:
    """Compile a function that works on arrays it is given: it cannot make any, nor assign whole arrays.

    It does without numba's counting of references, which otherwise takes most of the time of a small
    step: every call counts every array of every NamedTuple up and down.
    """
    return _compiled(function, WITHOUT_COUNTING)


def inlined(function: F) -> F:
    """Like `kernel`, for a small function that becomes part of those that call it."""
    return _compiled(function, INLINED)


def inlined_for_any_problem(function: F) -> F:
    """The same for a function that gets a problem's `arrays`, whose type no other program may know: never kept."""
    return _compiled(function, INLINED, keep=False)


WITHOUT_COUNTING = {"_nrt": False}
INLINED = {"_nrt": False, "forceinline": True}
Compiler = Callable[[Callable[..., Any]], Callable[..., Any]]


def _compiled(function: F, options: dict[str, bool], keep: bool | None = None) -> F:
    """Machine code, kept on disk or not; by default only the package's own, whose changes change the folder's name."""
    if keep is None:
        keep = Path(function.__code__.co_filename).is_relative_to(PACKAGE)
    with _making:
        decorated: F = numba.njit(cache=keep, nogil=True, error_model="numpy", **options)(function)
    return decorated


def _by_name(dispatcher: Any) -> Any:
    """How a compiled function goes to another process: by name, so that it is found compiled there.

    Numba would send its code, to be compiled again. That is right for what no worker can import: functions of a script,
    and those that belong to no module (see `specialised`).
    """
    name = dispatcher.__qualname__
    module = dispatcher.__module__
    own = module != "__main__" and getattr(sys.modules.get(module), name, None) is dispatcher
    return name if own else dispatcher.__reduce__()


copyreg.pickle(CPUDispatcher, _by_name)


def specialised(template: Callable[..., Any], compiler: Compiler = compiled, **parts: Any) -> Callable[..., Any]:
    """A compiled copy of a plain function in which the global names `parts` stand for these compiled functions.

    So one kernel serves every problem: the problem's functions become part of its machine code. Equal
    templates and parts give the same compiled function.
    """
    with _making:
        return _specialised(template, compiler, tuple(sorted(parts.items())))


@cache
def _specialised(
    template: Callable[..., Any], compiler: Compiler, parts: tuple[tuple[str, Hashable], ...]
) -> Callable[..., Any]:
    assert isinstance(template, FunctionType)
    copy = FunctionType(
        template.__code__, {**template.__globals__, **dict(parts)}, template.__name__, template.__defaults__
    )
    copy.__module__, copy.__qualname__, copy.__doc__ = template.__module__, template.__qualname__, template.__doc__
    meanings = [_meaning(part) for part in (template, *(part for _, part in parts))]
    key = hashlib.sha256(repr(meanings).encode()).hexdigest()[:DIGEST_LENGTH]
    common = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(Path(common) / key)
    try:
        made = compiler(copy)
    finally:
        numba.config.CACHE_DIR = common
    copy.__globals__[template.__name__] = made  # so that it can call itself
    return made


def _meaning(value: object, inside: tuple[object, ...] = (), names: Sequence[str] = ()) -> object:
    """What a compiled function's behaviour depends on: its code and, in turn, all the globals it names.

    inside: the functions and modules that led here; names: those that the function may look up in a module.
    """
    function = getattr(value, "py_func", value)
    if any(function is outer for outer in inside):
        return getattr(function, "__name__", "")
    if isinstance(function, FunctionType):
        known, names = function.__globals__, _names(function.__code__)
        way = (*inside, function)
        used = {name: _meaning(known[name], way, names) for name in names if name in known}
        cells = [_meaning(cell.cell_contents, way, names) for cell in function.__closure__ or ()]
        origin = [function.__module__, _source(Path(function.__code__.co_filename))]
        usual = [repr(function.__defaults__), repr(function.__kwdefaults__)]
        return [origin, _plain(function.__code__), used, cells, usual]
    if isinstance(value, np.ndarray):
        return [value.dtype.str, value.shape, value.tobytes()]
    if isinstance(value, type):
        members = (
            {name: repr(member.value) for name, member in value.__members__.items()} if issubclass(value, Enum) else {}
        )
        module = sys.modules.get(value.__module__)
        return [value.__module__, value.__qualname__, members, _source(Path(getattr(module, "__file__", None) or ""))]
    if isinstance(value, tuple):
        return [_meaning(item, inside, names) for item in value]
    if isinstance(value, ModuleType):
        file = Path(getattr(value, "__file__", None) or "")  # a built-in module has none
        foreign = file.suffix == ".py" and "site-packages" not in file.parts and not file.is_relative_to(PACKAGE)
        looked_up = [name for name in names if foreign and hasattr(value, name)]
        way = (*inside, value)
        return [value.__name__, {name: _meaning(getattr(value, name), way, names) for name in looked_up}]
    return repr(value)


@cache
def _source(file: Path) -> str:
    """Digest of a file outside the package: its functions are given types that are defined there, too."""
    foreign = file.is_file() and not file.is_relative_to(PACKAGE)
    return hashlib.sha256(file.read_bytes()).hexdigest() if foreign else ""


def _names(code: CodeType) -> list[str]:
    inner = [name for constant in code.co_consts if isinstance(constant, CodeType) for name in _names(constant)]
    return sorted({*code.co_names, *inner})


def _plain(code: CodeType) -> object:
    constants = [_plain(item) if isinstance(item, CodeType) else repr(item) for item in code.co_consts]
    return [code.co_code, constants, code.co_names, code.co_varnames]

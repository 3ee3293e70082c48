"""What is wrong with a problem's own functions, told in its author's terms: the function, its file, the rule."""

import inspect
import linecache
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
from numba.core.errors import NumbaError

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.files import PACKAGE
from fatigue_planner.core.jit import compiled

RULES = (
    "allowed are numbers, tuples, loops, other functions compiled with fp.compiled, NumPy's functions of numbers, and "
    "reading and writing the elements of the arrays that the function is given"
)
# What numba says, and what its user has to do about it.
HINTS = {
    r"name '(\w+)' is not defined": "{0} is not defined: define it in the module, or put it into the problem's arrays",
    r"Unknown attribute '(\w+)' of type none": "the problem's arrays are None: they have no {0}",
    r"Unknown attribute '(\w+)' of type NamedTuple\w*\((\w+)": "{1} has no {0}",
    r"Unknown attribute '(\w+)'": "there is no {0}",
    r"Untyped global name '(\w+)'": "{0} is neither a number, an array nor a compiled function: decorate it with "
    "fp.compiled",
    r"float\(\) only support for numbers|float\(bool\)": "a truth value is no number: write 1.0 if x else 0.0",
    r"Can't unify return type|Cannot unify": "it must return, or a variable must be, the same type everywhere: "
    "write 0.0 for a number without a fraction",
    r"built-in function (?:array|empty|zeros|ones|full|copy)>|NRT required but not enabled": "it makes a new array; "
    "write into the arrays it is given instead",
    r"Cannot determine Numba type of <class '([\w.]+)'>": "compiled code knows no {0}",
}
_PLACE = re.compile(r'File "([^"]+)", line (\d+)')


def checked(name: str, function: Callable[..., Any], arguments: tuple[str, ...]) -> Callable[..., Any]:
    """The function, compiled if it is not yet. Raises ProblemError if it does not take these arguments."""
    plain = getattr(function, "py_func", function)
    if not isinstance(plain, FunctionType):
        raise ProblemError(f"{name}: {function!r} is no function; write one with def and decorate it with fp.compiled.")
    parameters = inspect.signature(plain).parameters.values()
    most = sum(p.kind in {p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD} for p in parameters)
    least = sum(p.kind != p.VAR_POSITIONAL and p.default is p.empty for p in parameters)
    if not least <= len(arguments) <= most:
        raise ProblemError(
            f"{name}: your function {_place_of(plain)} takes {most} arguments; it must take {len(arguments)}: "
            f"({', '.join(arguments)})."
        )
    return function if hasattr(function, "py_func") else compiled(function)


def check_arrays(name: str, arrays: Any) -> None:
    """Raise ProblemError, naming the member, for arrays that compiled functions cannot get: numba crashes on some."""
    if isinstance(arrays, tuple):
        fields = getattr(arrays, "_fields", range(len(arrays)))
        for field, member in zip(fields, arrays, strict=True):
            check_arrays(f"{name}.{field}" if isinstance(field, str) else f"{name}[{field}]", member)
    elif isinstance(arrays, np.ndarray):
        if arrays.dtype.kind not in "biuf":
            raise ProblemError(f"{name}: an array of {arrays.dtype}; it must be one of numbers or truth values.")
    elif not isinstance(arrays, int | float | np.number | np.bool_ | None):
        raise ProblemError(
            f"{name}: {type(arrays).__name__}; it must be a number, a NumPy array, a NamedTuple of these, or None."
        )


class InTheUsersTerms:
    """A context in which errors of numba that these functions cause become ProblemErrors; it costs nothing else."""

    def __init__(self, functions: Mapping[str, Callable[..., Any] | None]) -> None:
        self._functions = functions

    def __enter__(self) -> None:
        """Nothing is done before something goes wrong."""

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        if isinstance(error, NumbaError):
            raise ProblemError(_told(str(error), self._functions)) from None


def no_number(name: str, function: Callable[..., Any], what: str, got: object) -> ProblemError:
    """The error of a function that does not return what it must."""
    plain = getattr(function, "py_func", function)
    return ProblemError(f"{name}: your function {_place_of(plain)} must return {what}; it returned {got!r}.")


def _told(message: str, functions: Mapping[str, Callable[..., Any] | None]) -> str:
    file, line = _users_place(message)
    text = linecache.getline(file, line).strip()
    names = [
        f"{name}: your function {_place_of(plain)}" for name, plain in _plain(functions) if _contains(plain, file, line)
    ]
    if not file:  # numba does not say where
        missing = re.search(r"name '(\w+)'", message)
        names = [
            f"{name}: your function {_place_of(plain)}"
            for name, plain in _plain(functions)
            if missing and missing[1] in plain.__code__.co_names
        ]
    called = f"({Path(file).name}, line {line}) " if file else ""
    where = names[0] if names else f"a function {called}that the problem's functions call"
    code = f" At line {line}, {text!r}:" if text else ""
    return f"{where} cannot be compiled.{code} {_reason(message)}; {RULES}."


def _users_place(message: str) -> tuple[str, int]:
    """The file and line outside the package and its libraries that numba names last."""
    places = [(Path(file).resolve(), int(line)) for file, line in _PLACE.findall(message)]
    places += [(Path(file).resolve(), int(line)) for file, line in re.findall(r"at (/\S+) \((\d+)\)", message)]
    own = [
        place
        for place in places
        if not place[0].is_relative_to(PACKAGE) and "site-packages" not in place[0].parts and place[0].is_file()
    ]
    return (str(own[0][0]), own[0][1]) if own else ("", 0)


def _reason(message: str) -> str:
    for pattern, hint in HINTS.items():
        if found := re.search(pattern, message):
            return hint.format(*found.groups())
    lines = [line.strip() for line in message.splitlines() if line.strip()]
    told = [line for line in lines if not line.startswith(("Failed in", "During", "File", "There are", "- Of which"))]
    return f"numba says: {told[0].rstrip('.:') if told else message}"


def _plain(functions: Mapping[str, Callable[..., Any] | None]) -> list[tuple[str, Any]]:
    return [(name, getattr(function, "py_func", function)) for name, function in functions.items() if function]


def _contains(plain: Any, file: str, line: int) -> bool:
    if Path(plain.__code__.co_filename).resolve() != Path(file):
        return False
    last = max((number for *_, number in plain.__code__.co_lines() if number), default=0)
    return bool(plain.__code__.co_firstlineno <= line <= last)


def _place_of(plain: Any) -> str:
    return f"{plain.__name__} ({Path(plain.__code__.co_filename).name}, line {plain.__code__.co_firstlineno})"

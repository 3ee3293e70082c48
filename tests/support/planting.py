"""Faults planted in a running program: a function becomes one in which a piece of its source is another.

Cheaper than a copy of the project (see `planted_faults`): nothing is compiled anew. A program that is started with
`program(fault)` has the fault from its beginning.
"""

import inspect
import os
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import pytest

Test = TypeVar("Test", bound=Callable[..., Any])


class Planted(NamedTuple):
    """In the function at "module:name" `old`, which is found there once, becomes `new`."""

    where: str
    old: str
    new: str


def function_at(where: str) -> Any:
    """The plain function at a place; that of a property or a class method is inside."""
    module, _, path = where.partition(":")
    found: Any = import_module(module)
    for name in path.split("."):
        found = inspect.getattr_static(found, name)
    return inspect.unwrap(getattr(found, "__func__", getattr(found, "fget", found)))


def plant(fault: Planted) -> Callable[[], None]:
    """Plant a fault; what is returned removes it."""
    function = function_at(fault.where)
    source = textwrap.dedent(inspect.getsource(function))
    assert source.count(fault.old) == 1, f"{fault.where}: {source.count(fault.old)} places are {fault.old!r}"
    lines = source.replace(fault.old, fault.new)
    lines = lines[min(lines.index(word) for word in ("def ", "async def ") if word in lines) :]
    # inside another function, which has what it closes over, such as the class that `super` needs
    closed = "".join(f"    {name} = None\n" for name in function.__code__.co_freevars)
    outer = f"def outer():\n{closed}{textwrap.indent(lines, '    ')}\n    return {function.__name__}\n"
    namespace: dict[str, Any] = {}
    exec(compile(outer, fault.where, "exec"), function.__globals__, namespace)
    before, function.__code__ = function.__code__, namespace["outer"]().__code__

    def remove() -> None:
        function.__code__ = before

    return remove


@contextmanager
def planted(fault: Planted) -> Iterator[None]:
    """With a fault inside, without it afterwards."""
    remove = plant(fault)
    try:
        yield
    finally:
        remove()


def program(fault: Planted) -> str:
    """What a process that is to have the fault runs before its own program."""
    here = Path(__file__).parent
    return f"import sys; sys.path.append({str(here)!r}); import planting; planting.plant(planting.{fault!r})\n"


def fails_with(where: str, old: str, new: str) -> Callable[[Test], Test]:
    """Mark a test as one that must fail with this fault."""

    def marked(test: Test) -> Test:
        test.fault = Planted(where, old, new)  # type: ignore[attr-defined]
        return test

    return marked


def run_pytest(arguments: list[str], folder: Path, instead_of: Path, environment: dict[str, str], said: Path) -> None:
    """As a process of its own: run pytest in a copy of the project with the copy's modules; `said`: what it prints."""
    with said.open("wb") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    own = [path for path in sys.path if "site-packages" in path or not Path(path).is_relative_to(instead_of)]
    sys.path[:] = [str(folder), *own]
    sys.exit(pytest.main(arguments))

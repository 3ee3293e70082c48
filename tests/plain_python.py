"""Kernels as plain Python, with other parts in them: for parts with planted errors, without compiling any."""

from collections.abc import Callable
from types import FunctionType
from typing import Any

import pytest

from fatigue_planner.planners import pomcp
from fatigue_planner.planners.parts import search_kernel
from fatigue_planner.pomdp.beliefs import exact


def interpreted(kernel: Any, **parts: Any) -> FunctionType:
    """A copy of a compiled function that Python runs, and all it calls; `parts` by name in place of its own."""
    plain = getattr(kernel, "py_func", kernel)
    names = dict(plain.__globals__)
    for name in plain.__code__.co_names:
        if name in parts:
            names[name] = parts[name]
        elif hasattr(names.get(name), "py_func"):
            names[name] = interpreted(names[name], **parts)
    return FunctionType(plain.__code__, names, plain.__name__, plain.__defaults__, plain.__closure__)


def plant_in_search(monkeypatch: pytest.MonkeyPatch, **parts: Callable[..., Any]) -> None:
    """Let every search run as plain Python, with these parts."""
    monkeypatch.setattr(pomcp, "search_kernel", lambda *which: interpreted(search_kernel(*which), **parts))


def plant_in_belief(monkeypatch: pytest.MonkeyPatch, **parts: Callable[..., Any]) -> None:
    """Let exact beliefs be updated by plain Python, with these parts."""
    original = exact.specialised
    monkeypatch.setattr(exact, "specialised", lambda *args, **own: interpreted(original(*args, **own), **parts))

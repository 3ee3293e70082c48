"""Kernels run as plain Python with other parts, for planted errors without compilation."""

from collections.abc import Callable
from types import FunctionType
from typing import Any

import numpy as np
import pytest

from fatigue_planner.planners.pomcp import policy
from fatigue_planner.planners.pomcp.kernels import search_kernel
from fatigue_planner.pomdp import simd

# The vector code and what it is made of: whether it stores the state, and sums squares.
STEPS = {simd.move: (True, True), simd.sum_of_squares_after: (False, True), simd.quadratic: (False, False)}


def interpreted(kernel: Any, **parts: Any) -> FunctionType:
    """A copy, run by Python, of a compiled function and all it calls; `parts` replace functions by name."""
    plain = getattr(kernel, "py_func", kernel)
    names = dict(plain.__globals__)
    for name in plain.__code__.co_names:
        if name in parts:
            names[name] = parts[name]
        elif any(names.get(name) is step for step in STEPS):
            store, squares = next(kind for step, kind in STEPS.items() if step is names[name])
            names[name] = simd._interpreted(store, squares)
        elif names.get(name) is simd.move_along:
            names[name] = simd._plain_steps
        elif names.get(name) is simd.put:
            names[name] = simd._plain_put
        elif hasattr(names.get(name), "py_func"):
            names[name] = interpreted(names[name], **parts)
    return FunctionType(plain.__code__, names, plain.__name__, plain.__defaults__, plain.__closure__)


def plant_in_search(monkeypatch: pytest.MonkeyPatch, **parts: Callable[..., Any]) -> None:
    """Let every search run as plain Python, with these parts."""

    def plain_kernel(*which: Any) -> Callable[..., int]:
        grow = interpreted(search_kernel(*which), **parts)
        names = grow.__code__.co_varnames[: grow.__code__.co_argcount]

        def run(*values: Any) -> int:
            tree = values[names.index("tree")]
            fields_as_attributes = tree._replace(nodes=tree.nodes.view(np.recarray))
            return int(grow(*(fields_as_attributes if value is tree else value for value in values)))

        return run

    monkeypatch.setattr(policy, "search_kernel", plain_kernel)

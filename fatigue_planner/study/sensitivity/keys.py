"""Dotted paths into the settings of an experiment, e.g. `benchmark.policies.pomcp_0.1.descents`."""

import difflib
from collections.abc import Mapping
from typing import Any

from fatigue_planner.core.errors import ExperimentError

KeyPath = tuple[str, ...]


def find(settings: Mapping[str, Any], key: str) -> KeyPath:
    """The names along a dotted path; names may contain dots, so they are matched with the known ones.

    Raises ExperimentError, with a suggestion, if there is no such setting.
    """
    node: Any = settings
    path: KeyPath = ()
    rest = key
    while rest:
        known = [name for name in node if rest == name or rest.startswith(f"{name}.")] if isinstance(node, dict) else []
        if not known:
            raise ExperimentError(f"{key}: unknown key{_suggestion(node, path, rest)}")
        name = max(known, key=len)
        path, node, rest = (*path, name), node[name], rest[len(name) + 1 :]
    return path


def value_at(settings: Mapping[str, Any], path: KeyPath) -> Any:
    """The setting at a path."""
    node: Any = settings
    for name in path:
        node = node[name]
    return node


def with_value(content: Mapping[str, Any], path: KeyPath, value: Any) -> dict[str, Any]:
    """A copy of the content with another value at a path; mappings that it lacks are added."""
    name, *rest = path
    return {**content, name: with_value(content.get(name) or {}, tuple(rest), value) if rest else value}


def overlap(first: KeyPath, second: KeyPath) -> bool:
    """Whether the paths are equal or one is above the other."""
    shorter = min(len(first), len(second))
    return first[:shorter] == second[:shorter]


def _suggestion(node: Any, path: KeyPath, rest: str) -> str:
    where = ".".join(path) or "the experiment"
    if not isinstance(node, dict):
        return f"; {where} has no settings of its own."
    close = difflib.get_close_matches(rest.split(".", maxsplit=1)[0], node, n=1)
    if close:
        return f"; did you mean {'.'.join([*path, close[0]])!r}?"
    return f"; {where} has {', '.join(node)}."

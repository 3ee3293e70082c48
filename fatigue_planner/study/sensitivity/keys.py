"""Dotted paths into the settings of an experiment, e.g. `benchmark.policies.pomcp_0.1.descents`."""

import difflib
from collections.abc import Mapping
from typing import Any

from fatigue_planner.core.errors import ExperimentError

KeyPath = tuple[str, ...]


def find(settings: Mapping[str, Any], key: str) -> KeyPath:
    """The names along a dotted path; names may have dots themselves, so they are matched with those there are.

    Raises ExperimentError, with what is meant perhaps, if there is no such setting.
    """
    here: Any = settings
    path: KeyPath = ()
    rest = key
    while rest:
        known = [name for name in here if rest == name or rest.startswith(f"{name}.")] if isinstance(here, dict) else []
        if not known:
            raise ExperimentError(f"{key}: unknown key{_suggestion(here, path, rest)}")
        name = max(known, key=len)
        path, here, rest = (*path, name), here[name], rest[len(name) + 1 :]
    return path


def value_at(settings: Mapping[str, Any], path: KeyPath) -> Any:
    """The setting at a path."""
    here: Any = settings
    for name in path:
        here = here[name]
    return here


def with_value(content: Mapping[str, Any], path: KeyPath, value: Any) -> dict[str, Any]:
    """A copy of the content with another value at a path; what the content leaves to defaults is added."""
    name, *rest = path
    return {**content, name: with_value(content.get(name) or {}, tuple(rest), value) if rest else value}


def overlap(one: KeyPath, other: KeyPath) -> bool:
    """Whether one path is the other's, or leads to it."""
    shorter = min(len(one), len(other))
    return one[:shorter] == other[:shorter]


def _suggestion(here: Any, path: KeyPath, rest: str) -> str:
    where = ".".join(path) or "the experiment"
    if not isinstance(here, dict):
        return f"; {where} has no settings of its own."
    close = difflib.get_close_matches(rest.split(".", maxsplit=1)[0], here, n=1)
    if close:
        return f"; did you mean {'.'.join([*path, close[0]])!r}?"
    return f"; {where} has {', '.join(here)}."

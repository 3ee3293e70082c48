"""The leaves of settings: those that a schema knows, and those that an experiment has, under the same names.

A name is the path of a key, with * for a key of a mapping, [] for an index of a list and <kind> where settings come in
several kinds: `actions.*.loads.[].<mass>.mass_kg`.
"""

import types
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from fatigue_planner.core.plugins import Registry, annotation_of
from fatigue_planner.core.settings import Settings

Path = tuple[str | int, ...]


@dataclass(frozen=True)
class Leaf:
    """A value in an experiment: its path there, the schema's name of it, the value, and what else it may be."""

    path: Path
    name: str
    value: Any
    choices: tuple[Any, ...]


def schema_leaves(annotation: Any, name: str = "") -> set[str]:
    """The names of all leaves below a type."""
    found: set[str] = set()
    for kind, below in _ways(annotation, name):
        if isinstance(kind, type) and issubclass(kind, Settings):
            for key, field in kind.model_fields.items():
                found |= schema_leaves(annotation_of(field), _join(below, field.alias or key))
        elif get_origin(kind) is dict:
            found |= schema_leaves(get_args(kind)[1], _join(below, "*"))
        elif get_origin(kind) is tuple:
            found |= schema_leaves(get_args(kind)[0], _join(below, "[]"))
        else:
            found.add(below)
    return found


def leaves(value: Any, annotation: Any, name: str = "", path: Path = ()) -> Iterator[Leaf]:
    """The leaves of a value of a type; what is left out (None) is none."""
    if value is None:
        return
    if isinstance(value, Settings):
        below = name if len(list(_ways(annotation, name))) < 2 else _join(name, f"<{_tag(type(value))}>")
        for key, field in type(value).model_fields.items():
            alias = field.alias or key
            yield from leaves(getattr(value, key), annotation_of(field), _join(below, alias), (*path, alias))
        return
    kinds = [kind for kind, _ in _ways(annotation, name)]
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, get_args(kinds[0])[1], _join(name, "*"), (*path, key))
    elif isinstance(value, tuple):
        for index, item in enumerate(value):
            yield from leaves(item, get_args(kinds[0])[0], _join(name, "[]"), (*path, index))
    else:
        choices = tuple(choice for kind in kinds if get_origin(kind) is Literal for choice in get_args(kind))
        yield Leaf(path, name, value, choices)


def groups(value: Any, path: Path = ()) -> Iterator[tuple[Path, Settings]]:
    """Every group of settings in a value, with its path."""
    below: Any = ()
    if isinstance(value, Settings):
        yield path, value
        below = ((field.alias or key, getattr(value, key)) for key, field in type(value).model_fields.items())
    elif isinstance(value, dict | tuple):
        below = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in below:
        yield from groups(item, (*path, key))


def _ways(annotation: Any, name: str) -> Iterator[tuple[Any, str]]:
    """The types that a value may be of, None aside, each with the name that leads into it."""
    while get_origin(annotation) is Annotated or hasattr(annotation, "__value__"):
        if isinstance(getattr(annotation, "__metadata__", ("",))[0], Registry):
            annotation = Union[tuple(annotation.__metadata__[0].kinds().values())]  # noqa: UP007
            continue
        annotation = annotation.__value__ if hasattr(annotation, "__value__") else get_args(annotation)[0]
    if get_origin(annotation) in (Union, types.UnionType):
        kinds = [kind for part in get_args(annotation) if part is not type(None) for kind, _ in _ways(part, name)]
        several = len(kinds) > 1
        for kind in kinds:
            yield kind, _join(name, f"<{_tag(kind)}>") if several else name
    else:
        yield annotation, name


def _tag(kind: type[Settings]) -> str:
    return str(get_args(kind.model_fields["kind"].annotation)[0])


def _join(name: str, part: str) -> str:
    return f"{name}.{part}" if name else part

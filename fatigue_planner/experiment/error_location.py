"""Where in a file an error is that pydantic has located, and what type of value belongs there."""

from collections.abc import Sequence
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from fatigue_planner.core.plugins import Registry, annotation_of
from fatigue_planner.core.settings import Settings

Location = tuple[int | str, ...]


def locate(kind: type[Settings], location: Location) -> tuple[list[int | str], Any]:
    """The path in a file of settings of a kind, and the type of what belongs there; None if unknown.

    Inside an entry with a `kind`, pydantic's location names the kind, too; the path in the file does not.
    """
    parts: list[int | str] = []
    here: Any = kind
    for step in location:
        members = _members(here)
        if members:
            here = members.get(step)
            continue
        parts.append(step)
        here = _below(here, step)
    return parts, _plain(here)


def kinds_of(expected: Any) -> Sequence[str]:
    """The kinds among which an entry of a type can choose, in quotes."""
    return [repr(kind) for kind in _members(expected)]


def _below(here: Any, step: int | str) -> Any:
    plain = _plain(here)
    if isinstance(plain, type) and issubclass(plain, Settings):
        fields = {field.alias or name: annotation_of(field) for name, field in plain.model_fields.items()}
        return fields.get(str(step))
    if get_origin(plain) is dict:
        return get_args(plain)[1]
    return get_args(plain)[0] if get_origin(plain) is tuple else None


def _members(here: Any) -> dict[int | str, Any]:
    """The kinds of an extension point, or the members of a union of settings, by name; empty for any other type."""
    plain = _plain(here)
    if get_origin(plain) is Annotated:
        return {**plain.__metadata__[0].kinds()}
    if get_origin(plain) not in (Union, UnionType):
        return {}
    return {get_args(member.model_fields["kind"].annotation)[0]: member for member in get_args(plain)}


def _plain(here: Any) -> Any:
    """A type without what is said about it (unless that is an extension point), and without `| None`."""
    if get_origin(here) is Annotated:
        if isinstance(here.__metadata__[0], Registry):
            return here
        return _plain(get_args(here)[0])
    if get_origin(here) in (Union, UnionType):
        members = [member for member in get_args(here) if member is not NoneType]
        return _plain(members[0]) if len(members) == 1 else here
    return here

"""Values that depend on inputs that are not stated: the range, and what each input alone makes of it."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

from fatigue_planner.ergonomics.result import Decides, Phrase, Span


class Unknown(NamedTuple):
    """An input that is not stated: the value that is taken first, and what else it may be and how that is said."""

    key: str
    first: Any
    others: tuple[tuple[Any, Phrase], ...]


def spanned(
    value_of: Callable[[Mapping[str, Any]], float], unknown: Sequence[Unknown]
) -> tuple[Span, float, tuple[Decides, ...]]:
    """The range over all that unknown inputs may be, the value for the first of each, and what each alone changes."""
    first = {one.key: one.first for one in unknown}
    base = value_of(first)
    decides = []
    for one in unknown:
        for other, condition in one.others:
            alone = value_of(first | {one.key: other})
            if alone != base:
                decides.append(Decides(one.key, condition, alone))
    choices = [(one.first, *(other for other, _ in one.others)) for one in unknown]
    keys = [one.key for one in unknown]
    values = [value_of(dict(zip(keys, chosen, strict=True))) for chosen in product(*choices)]
    return Span(min(values), max(values)), base, tuple(decides)

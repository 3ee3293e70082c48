"""Is there an order of one call after the other that explains what several clients were answered at the same time?

The search of Wing and Gong (1993): calls that overlap may have happened in any order, others as they were.
"""

from typing import NamedTuple

Seen = dict[int, str | None]


class Call(NamedTuple):
    """A call, what was answered (cycle and action, or the name of an error), and when it began and ended."""

    kind: str
    cycle: int
    seen: str | None
    result: object
    began: float
    ended: float


def is_linearizable(history: list[Call], cycle: int) -> bool:
    """Whether some order explains the answers; `cycle` had been decided, and nothing was said of it before."""
    return _explained(sorted(history, key=lambda call: call.began), cycle, {}, cycle)


def _explained(left: list[Call], cycle: int, said: Seen, first: int) -> bool:
    """Whether what is left can follow, where this cycle has been decided and this has been said."""
    if not left:
        return True
    earliest = min(call.ended for call in left)
    for number, call in enumerate(left):
        if call.began > earliest:
            break
        after = _after(call, cycle, said, first)
        if after is not None and _explained(left[:number] + left[number + 1 :], *after, first):
            return True
    return False


def _after(call: Call, cycle: int, said: Seen, first: int) -> tuple[int, Seen] | None:
    """Where the session stands after a call that is made here; None if it would be answered otherwise."""
    answered = call.result[0] if isinstance(call.result, tuple) else call.result
    if call.kind == "decide":
        return (cycle, said) if answered == cycle else None
    if call.cycle == cycle:
        return (cycle + 1, said | {cycle: call.seen}) if answered == cycle + 1 else None
    if call.cycle > cycle or call.cycle < first:
        return (cycle, said) if answered == "CycleError" else None
    before = said[call.cycle]
    if before == call.seen:
        return (cycle, said) if answered == cycle else None
    if before is None:
        return (cycle, said | {call.cycle: call.seen}) if answered == cycle else None
    return (cycle, said) if answered == "ContradictionError" else None

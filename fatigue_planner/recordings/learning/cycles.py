"""Reading what was observed: cycles with their recognised reactions, and labelled repetitions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError, listed
from fatigue_planner.recordings.formats.text import named_rows
from fatigue_planner.recordings.learning.likelihood import UNSEEN, Numbers

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

MAX_CYCLES = 100_000
# More repetitions in a row of the table are a mistake: nobody labels that many.
MAX_COUNT = 1_000_000


@dataclass(frozen=True)
class Cycles:
    """Cycles of one worker, in order.

    actions, seen (n,): numbers of actions and of what reactions were recognised as, UNSEEN where nothing was; start_s
    (n,): when each began, None where cycles follow one another as planned.
    """

    actions: Numbers
    seen: Numbers
    start_s: Vector | None


def read_cycles(path: Path, actions: Sequence[str], observations: Sequence[str]) -> Cycles:
    """The cycles of a CSV file: `action`, `reaction` (empty: not seen) and, if it has it, `time_s`.

    Raises RecordingError: file, line, value, what is allowed.
    """
    rows = named_rows(path, ("action", "reaction"), ("time_s",))
    if len(rows) > MAX_CYCLES:
        raise RecordingError(f"{path}: has {len(rows)} cycles; at most {MAX_CYCLES}.")
    done = [_index(path, line, "action", row["action"], actions) for line, row in rows]
    seen = [
        UNSEEN if not row["reaction"] else _index(path, line, "reaction", row["reaction"], observations)
        for line, row in rows
    ]
    start_s = None
    if "time_s" in rows[0][1]:
        start_s = np.array([_number(path, line, "time_s", row["time_s"]) for line, row in rows])
        if (later := np.flatnonzero(np.diff(start_s) <= 0)).size:
            raise RecordingError(f"{path}, line {rows[later[0] + 1][0]}: time_s should grow from cycle to cycle.")
    return Cycles(np.array(done, np.int64), np.array(seen, np.int64), start_s)


def read_labelled(
    path: Path, actions: Sequence[str], preferences: Sequence[str], observations: Sequence[str]
) -> tuple[Array, Numbers]:
    """Labelled repetitions (G, U, O) of a CSV file, and which of the G matrices is that of each action (A,).

    Columns: `preference`, `recognised`, `count` and, if it has it, `action`; without it one matrix holds for all.

    Raises RecordingError: file, line, value, what is allowed; a preference that was never repeated.
    """
    rows = named_rows(path, ("preference", "recognised", "count"), ("action",))
    by_action = "action" in rows[0][1]
    groups = np.arange(len(actions)) if by_action else np.zeros(len(actions), np.int64)
    counts = np.zeros((len(actions) if by_action else 1, len(preferences), len(observations)))
    for line, row in rows:
        group = _index(path, line, "action", row["action"], actions) if by_action else 0
        u = _index(path, line, "preference", row["preference"], preferences)
        o = _index(path, line, "recognised", row["recognised"], observations)
        number = _number(path, line, "count", row["count"])
        if not 0 <= number <= MAX_COUNT or number != round(number):
            raise RecordingError(
                f"{path}, line {line}: count = {row['count']}: should be a whole number from 0 to {MAX_COUNT}."
            )
        counts[group, u, o] += number
    missing = [
        "/".join([actions[group]] * by_action + [preferences[u]]) for group, u in np.argwhere(counts.sum(axis=2) == 0)
    ]
    if missing:
        raise RecordingError(f"{path}: no labelled repetition of {listed(missing)}.")
    return counts, groups.astype(np.int64)


def _index(path: Path, line: int, column: str, value: str, known: Sequence[str]) -> int:
    if value not in known:
        raise RecordingError(f"{path}, line {line}: {column} = {value!r}: not one of {listed(known)}.")
    return known.index(value)


def _number(path: Path, line: int, column: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RecordingError(f"{path}, line {line}: {column} = {text!r}: should be a finite number.")
    return value

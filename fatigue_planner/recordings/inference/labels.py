"""Whose point is which: prefixes, points that nobody named, labels given twice."""

import re
from collections.abc import Sequence

import numpy as np

from fatigue_planner.core.errors import RecordingError, listed, shortened
from fatigue_planner.core.text import counted
from fatigue_planner.recordings.content import Points, Remark
from fatigue_planner.recordings.inference.finding import Finding

# How programs call points that they could not name.
_UNNAMED = re.compile(
    r"\*\d+|unlabell?ed\W*\d*|u?name\W?\d+|unknown\W*\d*|c_\d+|point \d+|marker\W?\d*|\W*", re.IGNORECASE
)


def named_points(points: Points, prefix: str | None) -> tuple[Points, list[Finding], list[Remark]]:
    """The points of one person, each label once and without prefix.

    Raises RecordingError if the file has several people and `prefix` names none of them.
    """
    chosen, kept, finding = _of_one_person(points.labels, prefix)
    remarks = []
    unnamed = [index for index in kept if _UNNAMED.fullmatch(_bare(points.labels[index]))]
    if unnamed and len(unnamed) < len(kept):
        remarks.append(Remark(3, f"{counted(len(unnamed), 'point')} that nobody named are left out."))
        kept = [index for index in kept if index not in set(unnamed)]
    by_label: dict[str, list[int]] = {}
    for index in kept:
        by_label.setdefault(_bare(points.labels[index]) if chosen else points.labels[index], []).append(index)
    seen = np.isfinite(points.position).all(axis=2).sum(axis=0)
    best = {label: max(several, key=lambda index: (seen[index], -index)) for label, several in by_label.items()}
    if twice := [f"{shortened(label)} ({len(several)})" for label, several in by_label.items() if len(several) > 1]:
        remarks.append(Remark(4, f"labels given several times; the first most complete is kept: {listed(twice)}."))
    return Points(tuple(best), points.position[:, list(best.values())]), finding, remarks


def _of_one_person(labels: Sequence[str], prefix: str | None) -> tuple[str, list[int], list[Finding]]:
    """The prefix, the indices of the points that have it, and what to tell."""
    prefixes = [label.rpartition(":")[0] for label in labels]
    known = list(dict.fromkeys(one for one in prefixes if one))
    if prefix is not None:
        prefix = prefix.removesuffix(":")
        if prefix not in known:
            raise RecordingError(
                f"no label begins with the prefix {shortened(prefix)}; prefixes are {listed(known) or 'none'}."
            )
        chosen, source = prefix, "given"
    elif len(known) > 1:
        raise RecordingError(f"has the labels of several people or things: {listed(known)}. Choose one with --prefix.")
    elif not known:
        return "", list(range(len(labels))), []
    else:
        chosen, source = known[0], "the same before all labels"
    kept = [index for index, one in enumerate(prefixes) if one == chosen]
    return chosen, kept, [Finding("prefix", chosen, source)]


def _bare(label: str) -> str:
    return label.rpartition(":")[2].strip()

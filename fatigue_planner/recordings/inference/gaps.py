"""What is missing of points, and what jumps."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import listed
from fatigue_planner.core.text import counted, percent
from fatigue_planner.recordings.content import Points, Remark

Vector = NDArray[np.float64]

# Gaps are bridged up to here, and degrade a recording up to there.
BRIDGED_S, DEGRADED_S = 0.2, 0.5
# No part of a body moves faster (a thrower's hand: 20 m/s), or changes its speed so abruptly between two frames.
MAX_SPEED_MPS = 25.0
MAX_ACCELERATION_MPS2 = 600.0
LEAST_JUMP_M = 0.03
# Two points have changed places if each is this much nearer to where the other was.
SWAPPED = 0.3
MAX_TOLD = 5


def without_zeros(points: Points) -> tuple[Points, list[Remark]]:
    """Points at exactly (0, 0, 0) are missing ones; those that were never seen are left out."""
    position = points.position.copy()
    zero = (position == 0).all(axis=2)
    position[zero] = np.nan
    remarks = [Remark(5, f"{counted(int(zero.sum()), 'position')} at 0, 0, 0 taken as missing.")] if zero.any() else []
    seen = np.asarray(np.isfinite(position).all(axis=2).any(axis=0))
    if not seen.all():
        never = [label for label, there in zip(points.labels, seen, strict=True) if not there]
        remarks.append(Remark(5, f"never seen, left out: {listed(never)}."))
    labels = tuple(label for label, there in zip(points.labels, seen, strict=True) if there)
    return Points(labels, position[:, seen]), remarks


def gap_remarks(points: Points, rate_hz: float) -> list[Remark]:
    """What is missing, and the longest gaps: those between two frames in which a point is seen."""
    missing = np.asarray(~np.isfinite(points.position).all(axis=2))
    if not missing.any():
        return []
    longest = {}
    for label, gone in zip(points.labels, missing.T, strict=True):
        there = np.flatnonzero(~gone)
        if len(there) > 1 and (widest := int(np.diff(there).max()) - 1) > BRIDGED_S * rate_hz:
            longest[label] = widest / rate_hz
    text = f"{percent(float(missing.mean()), 1)} of the positions are missing"
    if longest:
        worst = sorted(longest, key=lambda label: -longest[label])
        told = listed(f"{label} {longest[label]:.2f} s" for label in worst[:MAX_TOLD])
        text += f"; {counted(len(worst), 'point has', 'points have')} gaps over {BRIDGED_S} s: {told}"
    return [Remark(5, f"{text}.")]


def jump_remarks(points: Points, rate_hz: float) -> list[Remark]:
    """Points, in m, that change places or jump between two frames; nothing is corrected."""
    position = points.position
    if len(position) < 3:
        return []
    step = np.diff(position, axis=0)
    most = max(LEAST_JUMP_M, MAX_ACCELERATION_MPS2 / rate_hz**2)
    change = np.linalg.norm(np.diff(step, axis=0), axis=2)
    jump = np.zeros(step.shape[:2], dtype=bool)
    with np.errstate(invalid="ignore"):
        length = np.linalg.norm(step, axis=2)
        abrupt = change > most
        jump[1:] = abrupt & (length[1:] > length[:-1])
        jump[:-1] |= abrupt & (length[:-1] > length[1:])
        jump |= length > MAX_SPEED_MPS / rate_hz
    swaps, alone = [], 0
    for frame in np.flatnonzero(jump.any(axis=1)):
        those: list[int] = np.flatnonzero(jump[frame]).tolist()
        while those:
            one = those.pop(0)
            other = next((o for o in those if _swapped(position[frame : frame + 2], one, o)), None)
            if other is None:
                alone += 1
            else:
                those.remove(other)
                swaps.append(f"{points.labels[one]} and {points.labels[other]} before frame {frame + 2}")
    remarks = [Remark(6, f"points change places: {listed(swaps[:MAX_TOLD])} ({len(swaps)} times).")] if swaps else []
    if alone:
        first, which = np.argwhere(jump)[0]
        where = f"the first: {points.labels[which]}, before frame {first + 2}"
        remarks.append(Remark(6, f"points jump {counted(alone, 'time')} as no body moves ({where})."))
    return remarks


def _swapped(two_frames: Vector, one: int, other: int) -> bool:
    before, after = two_frames[:, [one, other]]
    stay = np.linalg.norm(after - before, axis=1)
    return bool((np.linalg.norm(after - before[::-1], axis=1) < SWAPPED * stay).all())

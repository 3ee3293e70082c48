"""When a recorded person reaches, works and returns: by the speed of the working hands, or as the user says."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.motion.motion import Phase
from fatigue_planner.recordings.dynamics import smooth

Vector = NDArray[np.float64]

# A hand moves while it is faster than this share of its greatest speed, the field's usual onset of a movement.
ONSET_SHARE = 0.05
# Hands are smoothed for it by this cut-off; pauses shorter than this are none; a movement shorter than this share of
# the way to the work is part of the work (assumed).
SMOOTHED_HZ, PAUSE_S, LEAST_SHARE = 3.0, 0.3, 0.3
# A hand that ends farther from where it began than this share of the way to its work has not returned (assumed).
HOME_SHARE = 0.5
LEAST_S = 0.1


class Bounds(NamedTuple):
    """When the reach begins, and reach, work and return end, in s from the first frame."""

    begin_s: float
    reached_s: float
    leaves_s: float
    end_s: float

    def of(self, index: int) -> tuple[float, float]:
        """When a phase, by its number, begins and ends."""
        return self[index], self[index + 1]

    def times_s(self, phases: Sequence[Phase]) -> Vector:
        """When in the recording the ticks (T,) of a cycle are: each phase runs evenly through the recorded one."""
        return np.concatenate(
            [
                self[i] + (self[i + 1] - self[i]) * np.arange(phase.stop - phase.start) / (phase.stop - phase.start)
                for i, phase in enumerate(phases)
            ]
        )


def given_bounds(times_s: Sequence[float], duration_s: float) -> Bounds:
    """The bounds that a user says. Raises RecordingError unless they are four times of the recording that increase."""
    told = ", ".join(f"{time:g}" for time in times_s)
    if len(times_s) != len(Bounds._fields):
        raise RecordingError(f"--phases {told}: four times are needed: reach begins, work begins, return begins, end.")
    if not (np.diff(times_s) >= LEAST_S).all() or not times_s[0] >= 0 or not times_s[-1] <= duration_s:
        raise RecordingError(
            f"--phases {told}: must increase by {LEAST_S:g} s at least, within the recording's 0 to {duration_s:.2f} s."
        )
    return Bounds(*times_s)


def bounds_of(hands_m: Vector, rate_hz: float) -> Bounds:
    """The bounds by the ways (n, h, 3) m of the working hands: the first movement reaches, the last one returns.

    Raises RecordingError if there are not two movements with a pause between, or the hands do not come home.
    """
    way = smooth(hands_m, rate_hz, SMOOTHED_HZ)
    speed = np.linalg.norm(np.gradient(way, 1 / rate_hz, axis=0), axis=2).max(axis=1)
    moves = _runs(speed > ONSET_SHARE * speed.max(), max(1, round(PAUSE_S * rate_hz)))
    farthest = float(np.linalg.norm(way - way[0], axis=2).max())
    far = [
        (start, stop)
        for start, stop in moves
        if np.linalg.norm(way[stop - 1] - way[start], axis=1).max() >= LEAST_SHARE * farthest
    ]
    if len(far) < 2:
        raise RecordingError(
            f"the working hand makes {len(far) or 'no'} movement{'s' * (len(far) != 1)} with a pause before or after; "
            "a reach, a pause to work in and a return are needed. Say when they are with --phases."
        )
    (begin, reached), (leaves, end) = far[0], far[-1]
    if np.linalg.norm(way[end - 1] - way[begin], axis=1).max() > HOME_SHARE * farthest:
        raise RecordingError("the working hand does not return to where it began. Say the phases with --phases.")
    return Bounds(*(frame / rate_hz for frame in (begin, reached, leaves, end - 1)))


def _runs(moves: NDArray[np.bool_], pause: int) -> list[tuple[int, int]]:
    """Frames [start, stop) of movements; pauses shorter than `pause` frames are part of them."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moves.astype(int), [0]])))
    runs: list[tuple[int, int]] = []
    for start, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if runs and start - runs[-1][1] < pause:
            runs[-1] = runs[-1][0], stop
        else:
            runs.append((start, stop))
    return runs

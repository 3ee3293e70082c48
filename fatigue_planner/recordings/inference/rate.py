"""How many frames a second: what the header says, or the times, which must agree."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecordingError
from fatigue_planner.recordings.inference.finding import Finding

Vector = NDArray[np.float64]

# The rate that times show may differ by their rounding: by this share, and each by these seconds.
AGREES = 0.01
ROUNDED_S = 1e-3
MAX_RATE_HZ = 100_000.0


def frame_rate(times_s: Vector, stated_hz: float | None, given_hz: float | None) -> tuple[float, Finding]:
    """The rate of evenly spaced frames, exactly as stated where it is.

    Raises RecordingError if times do not increase, are not even, or contradict the header and none is given.
    """
    if stated_hz is not None and not 0 < stated_hz <= MAX_RATE_HZ:
        if given_hz is None:
            raise RecordingError(f"says {stated_hz:g} frames a second. Say the rate with --rate.")
        stated_hz = None
    if given_hz is not None:
        return given_hz, Finding("rate", f"{given_hz:g} Hz", "given")
    if len(times_s) == 1:
        if stated_hz is None:
            raise RecordingError("has one frame and no rate.")
        return stated_hz, Finding("rate", f"{stated_hz:g} Hz", "the header")
    steps = np.diff(times_s)
    if not (steps > 0).all():
        raise RecordingError(f"times do not increase at frame {int((~(steps > 0)).argmax()) + 2}. See --rate.")
    shown = (len(times_s) - 1) / float(times_s[-1] - times_s[0])
    if stated_hz is not None and abs(shown / stated_hz - 1) > AGREES and abs(1 / shown - 1 / stated_hz) > ROUNDED_S / 2:
        raise RecordingError(
            f"the header says {stated_hz:g} frames a second, the times {shown:.4g}. Say which is right with --rate."
        )
    rate = stated_hz if stated_hz is not None else shown
    off = abs(times_s - times_s[0] - np.arange(len(times_s)) / shown)
    if (worst := int(off.argmax())) and off[worst] > 0.25 / shown + ROUNDED_S:
        raise RecordingError(f"frames are not evenly spaced: frame {worst + 1} is {off[worst]:.3f} s off. See --rate.")
    if stated_hz is None and abs(shown - round(shown)) < AGREES * AGREES * shown:
        rate = float(round(shown))  # times with few decimals
    return rate, Finding("rate", f"{rate:.6g} Hz", "the times" if stated_hz is None else "the header, and the times")

"""Bounds of CPU time that hold on a slow machine, too: what is measured there is judged by that machine's own pace."""

import statistics
import time

# CPU time of `work` on the machine for which bounds are said. The fast tests took 282 s there, and 486 s on one on
# which `work` took 17 ms: 282 / 486 of that.
QUIET_S = 0.010


def work() -> float:
    """CPU time of this thread for a fixed piece of work, in seconds."""
    begin = time.thread_time()
    sum(number * number for number in range(300_000))
    return time.thread_time() - begin


def within(seconds: float, most: float) -> bool:
    """Whether CPU time is below a bound; if not, whether it is on the machine for which bounds are said."""
    return seconds < most or seconds < most * statistics.median(work() for _ in range(5)) / QUIET_S

"""Who answers goes first: before the threads that work beside, before garbage, and before other programs if permitted.

A thread that is woken may take the processor from the one that has woken it; one that works beside (SCHED_BATCH) does
not. Garbage in cycles is looked for while the worker works, and only among what was made since the shift was opened:
Python stops everything to look through all that is loaded, which takes longer than an answer may.

Real-time priority is for one thread only: processes and threads that it starts are ordinary. One that computes without
a pause for longer than any answer takes becomes ordinary, too, so that it cannot keep others from the machine.
"""

import gc
import os
import resource
import signal
import threading
from contextlib import suppress

# The lowest that goes before all ordinary programs leaves room for what the system itself must do.
PRIORITY = 1
LONGEST_S = 2


class OldObjects:
    """What was made before shifts were opened; as long as one is open nobody looks for garbage in it."""

    def __init__(self) -> None:
        self._lock, self._shifts = threading.Lock(), 0

    def leave_alone(self) -> None:
        """A shift is open, and all that it needs has been made."""
        with self._lock:
            self._shifts += 1
            gc.freeze()

    def look_at(self) -> None:
        """A shift is over; after the last one all is as it was."""
        with self._lock:
            self._shifts -= 1
            if not self._shifts:
                gc.unfreeze()


OLD_OBJECTS = OldObjects()


def collect_young() -> None:
    """Look for garbage among what was made lately, now that nobody waits; so it is not looked for within an answer."""
    gc.collect(1)


def work_beside() -> None:
    """From now on the calling thread takes the processor from nobody whom it does not wait for, where that can be."""
    with suppress(AttributeError, OSError):
        os.sched_setscheduler(0, os.SCHED_BATCH | os.SCHED_RESET_ON_FORK, os.sched_param(0))


def answer_first() -> str:
    """Give the calling thread, which must be the main one, real-time priority; why not, if that is not permitted."""
    if not hasattr(os, "SCHED_FIFO"):
        return "this system has no real-time priority"
    try:
        _, most = resource.getrlimit(resource.RLIMIT_RTTIME)
        resource.setrlimit(resource.RLIMIT_RTTIME, (LONGEST_S * 1_000_000, most))
        signal.signal(signal.SIGXCPU, _be_ordinary)
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(PRIORITY))
    except (OSError, ValueError) as error:
        return f"real-time priority is not permitted ({error}); allow it with LimitRTPRIO= or CAP_SYS_NICE"
    return ""


def _be_ordinary(*_: object) -> None:
    """Told that it has not paused for LONGEST_S."""
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))

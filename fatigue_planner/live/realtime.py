"""Real-time priority for the thread that answers, where the system permits it.

Only that thread: processes and threads that it starts are ordinary. One that computes without a pause for longer than
any answer takes becomes ordinary, too, so that it cannot keep others from the machine.
"""

import gc
import os
import resource
import signal

# The lowest that goes before all ordinary programs leaves room for what the system itself must do.
PRIORITY = 1
LONGEST_S = 2


def answer_first() -> str:
    """Give the calling thread, which must be the main one, real-time priority; why not, if that is not permitted.

    Garbage that nobody makes is not looked for: what has been made so far is left alone from now on.
    """
    gc.collect()
    gc.freeze()
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

"""Where a motion could not be simulated any further: the message of a failed motion."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.motion.body import Body
from fatigue_planner.motion.quality import Saturation, saturation
from fatigue_planner.motion.schedule import phases_of

Matrix = NDArray[np.float64]


def failure(body: Body, tick: int, torque_nm: Matrix) -> FailedMotionError:
    """The error of a tick without solution; `torque_nm` (tick, 39) is what was exerted before.

    It names time, phase, tick, the limit in the way and joints at their maximum torque. What the motion fails for is
    tested (see `causes`), not guessed.
    """
    settings = body.request.controller
    phases = phases_of(body.request.cycle, settings.time_step_s)
    phase = next(phase.name for phase in phases if tick < phase.stop)
    where = f"no admissible movement at t = {tick * settings.time_step_s:.2f} s ({phase}, tick {tick})"
    obstacle = body.controller.obstacle()
    if obstacle is None:
        return FailedMotionError(f"{where}: the equations of motion and of the feet contradict each other.")
    reason = f"{where}: {obstacle.kind.value} of {obstacle.location} ({obstacle.amount})"
    limits = (settings.torque_limit_factor * torque for torque in body.request.maximum_torque.vectors())
    before = saturation(torque_nm, *limits) if tick else Saturation("", 0.0, 0)
    if before.share > 0:
        since = before.first_tick * settings.time_step_s
        reason += f"; {before.joint} at its maximum torque {before.share:.0%} of the time, first at {since:.2f} s"
    return FailedMotionError(f"{reason}.")

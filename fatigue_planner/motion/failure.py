"""Why a motion could not be simulated, and what helps: the message of a failed motion."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import FailedMotionError, told_apart
from fatigue_planner.motion.body import Body
from fatigue_planner.motion.obstacle import LimitKind
from fatigue_planner.motion.quality import Saturation, saturation
from fatigue_planner.motion.schedule import phases_of

Matrix = NDArray[np.float64]

# A joint that is at its maximum torque for more of the time than this is not strong enough.
LASTING = 0.1


def failure(body: Body, tick: int, torque_nm: Matrix) -> FailedMotionError:
    """The error of a tick without solution; `torque_nm` (tick, 39) is what was exerted before.

    It names time, phase, tick, the limit in the way and joints at their maximum torque, and gives advice.
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
    weak = before.share > LASTING or obstacle.kind is LimitKind.TORQUE
    return FailedMotionError(f"{reason}. {_advice(body, obstacle.kind, weak)}")


def _advice(body: Body, kind: LimitKind, weak: bool) -> str:
    too_far = _too_far(body)
    if too_far:
        return f"Out of reach: {too_far}. Bring the object closer."
    loaded = bool(body.request.action.loads) or body.request.tool.mass_kg > 0
    if weak and loaded:
        return (
            "What the hands carry is too heavy for this worker in this posture: make the tool or the load lighter, or "
            "let the hands work closer to the body."
        )
    if weak:
        return "The worker is not strong enough for this: a closer object or a longer phase helps."
    if kind is LimitKind.JOINT:
        return "Bring the object closer or turn it, or make the phase longer."
    return "The body would lose its balance: bring the object closer or make the forces smaller."


def _too_far(body: Body) -> str:
    """Which hand's reference is farther from its shoulder than the arm is long, in words; empty if none."""
    person = body.human.anthropometry
    links = (person.joint_centre("right_elbow"), person.joint_centre("right_wrist"), person.grip_m())
    arm = sum(float(np.linalg.norm(link)) for link in links)
    for side, task in body.hands.items():
        shoulder = body.state.placement(body.state.frame(f"{side}_upper_arm")).translation
        away = float(np.linalg.norm(task.reference.position_m[task.index] - shoulder))
        if away > arm:
            distance, length = told_apart(away, arm, ".2f")
            return f"the {side} hand should be {distance} m from the shoulder, the arm measures {length} m"
    return ""

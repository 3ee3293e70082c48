"""Why a motion cannot be performed: what it asks for is left out, one thing at a time, and the motion tried again."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import pinocchio as pin

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.core.text import listing
from fatigue_planner.human.model import build_human
from fatigue_planner.motion.action import Action, Position, Waypoint
from fatigue_planner.motion.body import MotionRequest
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.payload import HandForce
from fatigue_planner.motion.settings import MAX_TICKS, Accuracy, Side
from fatigue_planner.motion.simulator import simulate

SLOWER = 2  # how many times as long everything lasts where the speed is left out
NEARER = 0.5  # of the way from the hanging hand to the target where the place is left out
# What helps, by what was left out.
REMEDIES = {
    "load": "make the tool, the load or the force smaller",
    "speed": "give the phases more time",
    "orientation": "turn the object, or leave orientation_deg out",
    "place": "bring the object closer",
}
# How the things left out are called where that did not help.
TRIALS = {
    "load": "without load",
    "speed": "at half the speed",
    "orientation": "with a free orientation",
    "place": "half-way to the hanging hand",
}


def on_target(motion: Motion) -> bool:
    """Whether the hands are at their targets during work, by the usual accuracy."""
    return bool(motion.hand_error_m[motion.phase("work")].max() <= Accuracy().hand_error_m)


def causes_of(request: MotionRequest) -> str:
    """Which of load, speed, orientation and place a motion fails for, in words: each is left out in turn.

    A trial succeeds if the motion can be performed with the hands at their targets.
    """
    tried = {name: _succeeds(changed) for name, changed in _left_out(request)}
    mended = [f"it works {TRIALS[name]}: {REMEDIES[name]}" for name, succeeds in tried.items() if succeeds]
    failed = [TRIALS[name] for name, succeeds in tried.items() if not succeeds]
    if failed:
        mended.append(f"it fails {listing(failed)}")
    return f"Tried again with one thing changed at a time, {'; '.join(mended)}"


def _succeeds(request: MotionRequest) -> bool:
    try:
        return on_target(simulate(request))
    except FailedMotionError:
        return False


def _left_out(request: MotionRequest) -> Iterator[tuple[str, MotionRequest]]:
    """The motion without one of the things that it asks for; what it does not ask for is not tried."""
    action = request.action
    if action.loads or request.tool.mass_kg > 0:
        light = request.tool.model_copy(update={"mass_kg": 0.0})
        yield "load", replace(request, tool=light, action=action.model_copy(update={"loads": ()}))
    if SLOWER * request.cycle.duration_s <= MAX_TICKS * request.controller.time_step_s:
        yield "speed", _slower(request)
    if any(goal.turned() for goal in action.goals().values()):
        free = _changed(action, lambda _, waypoint: waypoint.model_copy(update={"orientation_deg": None}))
        yield "orientation", replace(request, action=free)
    yield "place", replace(request, action=_nearer(request))


def _slower(request: MotionRequest) -> MotionRequest:
    cycle = request.cycle
    longer = {name: SLOWER * getattr(cycle, name) for name in ("reach_s", "work_s", "return_s")}
    later = _changed(
        request.action, lambda _, point: point.model_copy(update={"work_time_s": SLOWER * point.work_time_s})
    )
    loads = tuple(
        load.model_copy(
            update={
                "force_n": tuple(
                    force.model_copy(update={"cycle_time_s": SLOWER * force.cycle_time_s}) for force in load.force_n
                )
            }
        )
        if isinstance(load, HandForce)
        else load
        for load in later.loads
    )
    return replace(request, cycle=cycle.model_copy(update=longer), action=later.model_copy(update={"loads": loads}))


def _nearer(request: MotionRequest) -> Action:
    human = build_human(request.worker)
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, human.stance)

    def moved(side: Side, waypoint: Waypoint) -> Waypoint:
        hanging = data.oMf[human.model.getFrameId(f"{side}_grip")].translation
        x, y, z = (hanging + NEARER * (waypoint.position_m.vector() - hanging)).tolist()
        return waypoint.model_copy(update={"position_m": Position(x=x, y=y, z=max(z, 0.0))})

    return _changed(request.action, moved)


def _changed(action: Action, change: Callable[[Side, Waypoint], Waypoint]) -> Action:
    """The action with every waypoint of every hand changed; a pose to hold becomes a path of one waypoint."""
    goals = {}
    for side, goal in action.goals().items():
        path = {"position_m": None, "orientation_deg": None, "waypoints": tuple(change(side, p) for p in goal.path())}
        goals[f"{side}_hand"] = goal.model_copy(update=path)
    return action.model_copy(update=goals)

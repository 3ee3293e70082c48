"""Every worker at every place in every way: reached, missed, too weak or implausible. None of it is an error."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.executors.executor import Executor
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.target_checks import ROOM_M, ROOTED, Standing, standing_of
from fatigue_planner.human.model import build_human
from fatigue_planner.motion.causes import TRIALS
from fatigue_planner.motion.plausibility import Finding
from fatigue_planner.motion.quality import Quality
from fatigue_planner.motion.settings import Side
from fatigue_planner.reactions.cache import Outcome as Simulated
from fatigue_planner.reactions.cache import ReactionCache
from fatigue_planner.reactions.reaction import ReactionRequest
from fatigue_planner.station.assessment import Doing, Kind, Outcome
from fatigue_planner.station.experiments import Part, parts_of
from fatigue_planner.station.schema import Station

# What of a motion is not smooth says nothing of whether a person could work so.
SMOOTHNESS = ("torque_step_nm", "end_pose_deg", "end_speed_degps", "stance_load_share")
# A joint that is at its limit while a motion breaks off, as its message names it.
_AT_MAXIMUM = re.compile(r"; (\w+) at its maximum torque")


@dataclass(frozen=True)
class Task:
    """A motion of the station: who does what, with which hands, and the request for it."""

    doing: Doing
    hands: tuple[Side, ...]
    request: ReactionRequest


def tasks_of(station: Station) -> list[Task]:
    """All motions, operation by operation, worker by worker."""
    return [task for part in parts_of(station) for task in tasks_of_part(part)]


def tasks_of_part(part: Part) -> Iterator[Task]:
    """The motions of one experiment."""
    for request in reaction_requests(part.experiment):
        name = request.name
        way = next(way for way in part.station.ways if way == name.preference)
        yield Task(Doing(name.worker, part.operation, name.action, way), part.hands, request)


def simulate_all(
    tasks: Sequence[Task], cache: ReactionCache, executor: Executor, progress: Callable[[Simulated], None]
) -> list[Outcome]:
    """What becomes of every task, found in the cache or simulated; where no hand can be, nothing is simulated.

    Raises OutputFolderError if the cache cannot be written.
    """
    refused = _refusals(tasks)
    asked = [index for index in range(len(tasks)) if index not in refused]
    made = cache.complete([tasks[index].request for index in asked], executor, progress)
    found = {index: classified(tasks[index], simulated) for index, simulated in zip(asked, made, strict=True)}
    return [(refused | found)[index] for index in range(len(tasks))]


def classified(task: Task, simulated: Simulated) -> Outcome:
    """The outcome of a simulated motion.

    A motion that fails, and succeeds without its load, fails for want of strength; else the hand misses its place by
    what it is away from it. What fails otherwise, or shows what no person does, is implausible.
    """
    quality = _quality(simulated)
    findings = tuple(quality.plausibility.findings()) if quality else ()
    outcome = Outcome(
        task.doing,
        task.hands,
        _kind(task, simulated),
        load_share=quality.largest_load_share if quality else None,
        load_joint=quality.largest_load_joint if quality else "",
        findings=findings,
        detail=simulated.failure,
        digest=simulated.digest,
    )
    if outcome.kind == "missed":
        away = quality.work_hand_error_m if quality else None
        return replace(outcome, missed_m=away, findings=())
    if outcome.kind == "too_weak":
        at_maximum = _AT_MAXIMUM.search(simulated.failure)
        joint = quality.saturated_joint if quality else at_maximum[1] if at_maximum else ""
        return replace(outcome, joint=joint, findings=())
    return outcome


def _quality(simulated: Simulated) -> Quality | None:
    """The quality of a simulated motion; a station has no recorded ones."""
    return simulated.quality if isinstance(simulated.quality, Quality) else None


def odd_postures(quality: Quality) -> list[Finding]:
    """What a motion shows of postures that no person has at work."""
    return [finding for finding in quality.plausibility.findings() if finding.measure not in SMOOTHNESS]


def _kind(task: Task, simulated: Simulated) -> Kind:
    quality = _quality(simulated)
    if simulated.verdict != "failed":
        return "implausible" if quality is not None and odd_postures(quality) else "reached"
    accuracy = task.request.accuracy
    on_place = quality is not None and quality.work_hand_error_m <= accuracy.hand_error_m
    if on_place:
        return (
            "missed" if quality is not None and quality.work_hand_turn_rad > accuracy.hand_turn_rad else "implausible"
        )
    tried = quality.tested_causes if quality else simulated.failure
    return "too_weak" if f"it works {TRIALS['load']}" in tried else "missed"


def _refusals(tasks: Sequence[Task]) -> dict[int, Outcome]:
    """Outcomes that need no simulation, by number: places beyond the stretched body, in the body, or in the floor."""
    standing: dict[str, Standing] = {}
    found = {}
    for index, task in enumerate(tasks):
        doing, motion = task.doing, task.request.motion
        if doing.worker not in standing:
            standing[doing.worker] = standing_of(motion.worker, build_human(motion.worker))
        body = standing[doing.worker]
        for goal in motion.action.goals().values():
            point = goal.path()[0].position_m.vector()
            if outcome := _refusal(task, body, point):
                found[index] = outcome
    return found


def _refusal(task: Task, body: Standing, point: NDArray[np.float64]) -> Outcome | None:
    beyond = float(np.linalg.norm(point)) - body.longest_m
    if beyond > task.request.accuracy.hand_error_m:
        detail = f"at least {beyond:.2f} m beyond ankle, leg, trunk and arm together"
        return Outcome(task.doing, task.hands, "missed", missed_m=beyond, detail=detail)
    depths = body.depths_m(point)
    if depths.max() > ROOM_M:
        part = ROOTED[int(depths.argmax())].replace("_", " ")
        return _inside(task, f"in the {part} of the standing worker", float(depths.max()))
    if point[2] < body.fist_m:
        return _inside(task, "in the floor", body.fist_m - float(point[2]))
    return None


def _inside(task: Task, where: str, depth_m: float) -> Outcome:
    finding = Finding("place", depth_m, ROOM_M, f"the place of the fist is {100 * depth_m:.1f} cm {where}")
    return Outcome(task.doing, task.hands, "implausible", findings=(finding,), detail=finding.text)

"""The revised NIOSH lifting equation over the lifts of a cycle: lifting index, or composite index of several."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.lifting_equation import (
    METRIC,
    Duration,
    Lift,
    Place,
    composite_index,
    duration_class,
    multipliers,
)
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment, Level, Moment, Origin, Phrase, Unknown, spanned
from fatigue_planner.ergonomics.stated import Shift
from fatigue_planner.human.skeleton import SIDES

# The index up to which lifting is for nearly all, and above which it is a risk for nearly all.
GOAL, MOST = 1.0, 3.0
# What is done to a load that the equation is about.
LIFTED = ("lift", "lower")
# Hands that are faster lift at high speed, in m/s (30 inches per second).
HIGH_SPEED_MPS = 0.762
# The shortest and the longest way of a load up or down that the equation knows, in m.
SHORTEST_M, LONGEST_M = 0.25, 1.75


class NioshLifting(Indicator):
    """The lifting index of two-handed lifts; of several in a cycle, the composite one."""

    title: ClassVar[str] = "NIOSH lifting index"
    edition: ClassVar[str] = "DHHS (NIOSH) 94-110, revised 9/2021; metric constants; several lifts: composite index"
    origin: ClassVar[Origin] = Origin.AGREED

    kind: Literal["niosh_lifting"] = Field(
        default="niosh_lifting", description="The revised NIOSH lifting equation, 2021, with several tasks."
    )

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        lifting = [operation for operation in job.operations if operation.stated.handling in LIFTED]
        reason = self._refusal(job, lifting)
        if reason is not None:
            return self.does_not_apply(reason)
        unknown = self._unknown(job, lifting)

        def index(chosen: Mapping[str, Any]) -> float:
            return composite_index(
                [lift_of(operation, job, chosen) for operation in lifting],
                chosen.get("hours") or _duration(job.shift) or "long",
            )

        value, base, decides = spanned(index, unknown)
        first = {one.key: one.first for one in unknown}
        single = [composite_index([lift_of(operation, job, first)], "short") for operation in lifting]
        worst = lifting[int(np.argmax(single))]
        lift = lift_of(worst, job, first)
        start = worst.motion.phase("work").start * worst.motion.time_step_s
        levels = tuple(_level(end) for end in value)
        return self.answer(
            value=value,
            digits=1,
            levels=(levels[0], levels[1]),
            words=(_words(value.low), _words(value.high)),
            decides=tuple(one for one in decides if one.value > base),
            worst=Moment(worst.name, start, "", "low back"),
            parts=multipliers(lift.origin, lift.travel, lift.coupling)
            | {"load_kg": lift.load, "lifts_per_minute": lift.per_minute, "horizontal_cm": lift.origin.horizontal}
            | {"height_cm": lift.origin.height, "travel_cm": lift.travel, "asymmetry_deg": lift.origin.asymmetry_deg},
            remarks=self._remarks(lifting),
        )

    def _refusal(self, job: Job, lifting: list[Operation]) -> Phrase | None:
        """Why the equation may not be used, by its own list; None if it may."""
        if not lifting:
            return Phrase("nothing is lifted or lowered")
        if any(len(operation.request.action.goals()) < len(SIDES) for operation in lifting):
            return Phrase("one hand lifts; the equation is for two")
        if any(operation.stated.handling in ("push", "pull", "carry") for operation in job.operations):
            return Phrase("loads are also pushed, pulled or carried")
        if job.shift.hours is not None and _duration(job.shift) is None:
            return Phrase("more than 8 h of lifting")
        for operation in lifting:
            if not operation.load_kg.any():
                return Phrase("the lifted load is not known")
            if hand_speed_mps(operation) > HIGH_SPEED_MPS:
                return Phrase("the hands are faster than {most:g} m/s", {"most": HIGH_SPEED_MPS})
        return None

    def _unknown(self, job: Job, lifting: list[Operation]) -> list[Unknown]:
        found = []
        if job.shift.hours is None:
            longer = (("moderate", Phrase("if done for 1 to 2 h")), ("long", Phrase("if done for 2 to 8 h")))
            found.append(Unknown("hours", "short", longer))
        if any(operation.stated.coupling is None for operation in lifting):
            worse = (("fair", Phrase("with fair coupling")), ("poor", Phrase("with poor coupling")))
            found.append(Unknown("coupling", "good", worse))
        if any(operation.stated.placed_carefully is None for operation in lifting):
            found.append(Unknown("placed_carefully", False, ((True, Phrase("if placed with care")),)))
        if any(end_height_m(operation) is None for operation in lifting):
            farther = ((LONGEST_M, Phrase("if lifted by {most:g} m", {"most": LONGEST_M})),)
            found.append(Unknown("end_height_m", SHORTEST_M, farther))
        return found

    def _remarks(self, lifting: list[Operation]) -> tuple[Phrase, ...]:
        found = [
            Phrase("Room, floor, climate and a load that stays together are taken to be as the equation asks."),
            Phrase("At strong forward bending the limit exceeds 3400 N at L5/S1 (Arjmand 2015): see the compression."),
        ]
        if any(operation.stated.coupling == "unacceptable" for operation in lifting):
            found.append(Phrase("The equation has no coupling worse than poor."))
        if len(lifting) > 1:
            found.append(Phrase("Each lift's frequency multiplier is by its own height; the source leaves it open."))
        return tuple(found)


def lift_of(operation: Operation, job: Job, chosen: Mapping[str, Any]) -> Lift:
    """The lift that an operation is, in kg and cm: it begins where the hands are when the work begins."""
    stated = operation.stated
    begin, end = work_of(operation)
    origin = place_of(operation, begin)
    end_m = end_height_m(operation)
    begin_m = origin.height / 100
    travel_m = chosen["end_height_m"] if end_m is None else abs(end_m - begin_m)
    controlled = chosen["placed_carefully"] if stated.placed_carefully is None else stated.placed_carefully
    destination = None
    if controlled:
        there = place_of(operation, end)
        distance = there.horizontal if stated.end_distance_m is None else 100 * stated.end_distance_m
        if end_m is None:
            # the way decides where it ends, on the ground or as high as the equation goes at most (assumed)
            end_m = begin_m - travel_m if stated.handling == "lower" else begin_m + travel_m
            end_m = min(max(end_m, 0.0), METRIC.highest / 100)
        destination = Place(distance, 100 * end_m, there.asymmetry_deg)
    coupling = chosen["coupling"] if stated.coupling is None else stated.coupling
    return Lift(
        load=float(operation.load_kg[begin : end + 1].sum(axis=1).max()),
        origin=origin,
        destination=destination,
        travel=100 * travel_m,
        coupling="poor" if coupling == "unacceptable" else coupling,
        per_minute=60 * stated.times_per_cycle / job.cycle_s,
    )


def hand_speed_mps(operation: Operation) -> float:
    """The largest speed of the middle of both hands during the work."""
    begin, end = work_of(operation)
    middle = operation.posture.hand_m[begin : end + 1].mean(axis=1)
    return float(np.linalg.norm(np.diff(middle, axis=0), axis=1).max(initial=0.0) / operation.posture.step_s)


def work_of(operation: Operation) -> tuple[int, int]:
    """The first and last instant of the work."""
    work = operation.motion.phase("work")
    return math.ceil(work.start / operation.stride), (work.stop - 1) // operation.stride


def place_of(operation: Operation, instant: int) -> Place:
    """H and V in cm, A in degrees from straight ahead of the stance, which is not that of a twisted trunk."""
    seen = operation.posture
    middle = seen.hand_m[instant].mean(axis=0)
    ahead, left = (middle - seen.ankles_m[instant])[:2]
    angle = abs(float(np.degrees(np.arctan2(left, ahead))))
    return Place(100 * float(np.hypot(ahead, left)), 100 * float(middle[2]), angle)


def end_height_m(operation: Operation) -> float | None:
    """Where the load is set down: stated, else where a path of the hands ends; None if the hands hold one place."""
    if operation.stated.end_height_m is not None:
        return operation.stated.end_height_m
    if all(len(goal.path()) == 1 for goal in operation.request.action.goals().values()):
        return None
    return float(operation.posture.hand_m[work_of(operation)[1]].mean(axis=0)[2])


def _duration(shift: Shift) -> Duration | None:
    """The class of a shift whose hours are stated; spells and breaks that are not count as none."""
    if shift.hours is None:
        return None
    if shift.spells:
        return duration_class([(spell.work_h, spell.break_h) for spell in shift.spells])
    spell_h = min(shift.spell_h or shift.hours, shift.hours)
    sessions = math.ceil(shift.hours / spell_h - 1e-9)
    last_h = shift.hours - spell_h * (sessions - 1)
    return duration_class([(spell_h, shift.break_h or 0.0)] * (sessions - 1) + [(last_h, 0.0)])


def _level(index: float) -> Level:
    return Level.ACCEPTABLE if index <= GOAL else Level.INVESTIGATE if index <= MOST else Level.NOT_ACCEPTABLE


def _words(index: float) -> str:
    words = ("for nearly all workers", "an increased risk for some workers", "an increased risk for nearly all workers")
    return words[_level(index)] if math.isfinite(index) else "no load is recommended here"

"""What the hands do, as efforts of the revised strain index: what its composite and its cumulative index share."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fatigue_planner.ergonomics.held_posture import working
from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment, Level, Moment, Phrase, Unknown, spanned
from fatigue_planner.ergonomics.stated import Shift
from fatigue_planner.ergonomics.strain_equation import Effort, posture_multiplier, strain_index
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES

# Up to this index a job is usually called safe (recalled).
SAFE = 10.0
# What an unknown grip may be, as shares of the largest: noticeable, obvious, very strong.
GRIPS = (
    (0.3, Phrase("with a noticeable grip")), (0.5, Phrase("with an obvious grip")),
    (0.8, Phrase("with a very strong grip")),
)  # fmt: skip
HOURS = (1.0, 4.0, 8.0)


class HandStrain(Indicator):
    """An index of the worse hand. The grip is not simulated: the larger of it and the wrist's load counts."""

    @abstractmethod
    def index(self, efforts: Sequence[Effort], hours: float, shift: Shift) -> float:
        """The index of a hand that makes these efforts in a cycle, for so many hours."""

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        unknown = job.uncounted()
        if any(operation.stated.effort_share is None for operation in job.operations):
            unknown.append(Unknown("effort_share", 0.0, GRIPS))
        if job.shift.hours is None:
            longer = tuple((hours, Phrase("if done for {hours:g} h", {"hours": hours})) for hours in HOURS[1:])
            unknown.append(Unknown("hours", HOURS[0], longer))

        def of_side(side: str, chosen: Mapping[str, Any]) -> float:
            efforts = [
                effort_of(
                    operation, side, job.cycle_s, chosen.get("effort_share", 0.0), chosen.get("actions_per_minute")
                )
                for operation in job.working_with(side)
            ]
            return self.index(efforts, job.shift.hours or chosen["hours"], job.shift) if efforts else 0.0

        value, base, decides = spanned(lambda chosen: max(of_side(side, chosen) for side in SIDES), unknown)
        first = {one.key: one.first for one in unknown}
        side = max(SIDES, key=lambda one: of_side(one, first))
        hours = job.shift.hours or HOURS[0]
        working_there = job.working_with(side)
        efforts = [effort_of(operation, side, job.cycle_s, 0.0) for operation in working_there]
        which = int(np.argmax([strain_index(effort, hours) for effort in efforts]))
        levels = tuple(Level.ACCEPTABLE if end <= SAFE else Level.NOT_ACCEPTABLE for end in value)
        words = {Level.ACCEPTABLE: "up to 10", Level.NOT_ACCEPTABLE: "above 10"}
        start = working_there[which].motion.phase("work").start * working_there[which].motion.time_step_s
        return self.answer(
            value=value,
            digits=1,
            levels=(levels[0], levels[1]),
            words=(words[levels[0]], words[levels[1]]),
            decides=tuple(one for one in decides if one.value > base),
            worst=Moment(working_there[which].name, start, side, "hand and wrist"),
            parts=efforts[which]._asdict(),
            remarks=(Phrase("Intensity is the larger of the grip and the wrist's load; the grip is not simulated."),),
        )


def effort_of(
    operation: Operation, side: str, cycle_s: float, grip: float, actions_per_minute: float | None = None
) -> Effort:
    """The effort of a hand in an operation; `grip` and the number of actions are taken where none is stated."""
    stated, seen = operation.stated, operation.posture
    at_work = working(operation)
    wrist = [DEGREES_OF_FREEDOM.index(f"{side}_{name}") for name in ("wrist_flexion", "wrist_deviation")]
    load = float(np.abs(operation.torque_share[at_work][:, wrist]).max(axis=1).mean())
    # the source counts flexion as negative, the skeleton as positive
    bent = -seen.wrist_deg[at_work, SIDES.index(side)]
    worst = max(bent.tolist(), key=posture_multiplier)
    work = operation.motion.phase("work")
    work_s = (work.stop - work.start) * operation.motion.time_step_s
    actions = actions_per_minute if stated.actions_per_minute is None else stated.actions_per_minute
    if actions:
        per_cycle = actions / 60 * operation.seconds_per_cycle
        duration_s = stated.effort_s or min(work_s, 60 / actions)
    else:
        per_cycle, duration_s = stated.times_per_cycle, stated.effort_s or work_s
    return Effort(
        intensity=min(1.0, max(load, grip if stated.effort_share is None else stated.effort_share)),
        per_minute=60 * per_cycle / cycle_s,
        duration_s=duration_s,
        wrist_deg=worst,
    )

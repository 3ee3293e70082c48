"""DUET, the Distal Upper Extremity Tool (Gallagher, Schall, Sesek & Huangfu 2018, Human Factors 60, 1146-1162)."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment, Level, Moment, Origin, Phrase, Unknown, spanned
from fatigue_planner.human.skeleton import SIDES

# Damage of one effort at OMNI-RES 0 to 10.
DAMAGE = (
    2.6e-7, 4.5e-7, 1.37e-6, 4.13e-6, 1.262e-5, 3.801e-5, 1.1625e-4, 3.5014e-4, 1.05374e-3, 3.22581e-3, 9.70874e-3,
)  # fmt: skip
# The dose that parts cases from others best.
CUT_POINT = 0.03
HOURS = (1.0, 4.0, 8.0)
RATINGS = (
    (4, Phrase("if somewhat easy")), (6, Phrase("if somewhat hard")), (8, Phrase("if hard")),
    (10, Phrase("if extremely hard")),
)  # fmt: skip


def probability(dose: float) -> float:
    """The probability of an injury, or of pain in the last year, at a dose of damage in a day."""
    return 1 / (1 + math.exp(-(0.573 + 0.747 * math.log10(dose))))


class Duet(Indicator):
    """The probability, in %, at the dose of a day of the worse hand; efforts and their rating are stated."""

    title: ClassVar[str] = "DUET"
    edition: ClassVar[str] = "Gallagher et al. 2018; equation for injury and pain in the last year"
    origin: ClassVar[Origin] = Origin.AGREED

    kind: Literal["duet"] = Field(default="duet", description="DUET (Gallagher et al. 2018).")

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        unknown = job.uncounted()
        if any(operation.stated.omni_effort is None for operation in job.operations):
            unknown.append(Unknown("omni_effort", 2, RATINGS))
        if job.shift.hours is None:
            longer = tuple((hours, Phrase("if done for {hours:g} h", {"hours": hours})) for hours in HOURS[1:])
            unknown.append(Unknown("hours", HOURS[0], longer))

        def doses(side: str, chosen: Mapping[str, Any]) -> list[float]:
            cycles = 3600 * (job.shift.hours or chosen["hours"]) / job.cycle_s
            taken = chosen.get("omni_effort", 0), chosen.get("actions_per_minute")
            return [cycles * dose_per_cycle(one, *taken) for one in job.working_with(side)]

        sides = [side for side in SIDES if job.working_with(side)]
        value, base, decides = spanned(
            lambda chosen: 100 * probability(max(sum(doses(side, chosen)) for side in sides)), unknown
        )
        first = {one.key: one.first for one in unknown}
        side = max(sides, key=lambda one: sum(doses(one, first)))
        operations, own = job.working_with(side), doses(side, first)
        line = 100 * probability(CUT_POINT)
        levels = tuple(Level.ACCEPTABLE if end < line else Level.INVESTIGATE for end in value)
        words = ("below the cut point", "at or above the cut point")
        worst = operations[int(np.argmax(own))]
        start = worst.motion.phase("work").start * worst.motion.time_step_s
        return self.answer(
            value=value,
            digits=1,
            unit="%",
            levels=(levels[0], levels[1]),
            words=(words[levels[0]], words[levels[1]]),
            decides=tuple(one for one in decides if one.value > base),
            worst=Moment(worst.name, start, side, "hand and forearm"),
            parts={"dose": sum(own)} | {f"dose of {o.name}": d for o, d in zip(operations, own, strict=True)},
            remarks=(Phrase("The method knows no recovery."),),
        )


def dose_per_cycle(operation: Operation, otherwise: float, actions_per_minute: float | None = None) -> float:
    """The damage of an operation's efforts in a cycle; `otherwise` is taken where no rating is stated, and the number
    of actions where they are not counted.

    Between two ratings the damage is taken as linear in the logarithm (assumed; the paper has whole ratings).
    """
    stated = operation.stated
    efforts = stated.times_per_cycle
    actions = actions_per_minute if stated.actions_per_minute is None else stated.actions_per_minute
    if actions:
        efforts = actions / 60 * operation.seconds_per_cycle
    rating = otherwise if stated.omni_effort is None else stated.omni_effort
    return efforts * float(np.exp(np.interp(rating, np.arange(len(DAMAGE)), np.log(DAMAGE))))

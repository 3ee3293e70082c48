"""Whether efforts may be repeated all shift: the maximum acceptable effort (Potvin 2012, Human Factors 54, 175-188)."""

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.indicators.holding_time import entry_shares
from fatigue_planner.ergonomics.operation import Job
from fatigue_planner.ergonomics.result import Assessment, Level, Moment, Origin, Phrase, Span
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.human.skeleton import SIDES, without_side

Vector = NDArray[np.float64]

# The shortest duty cycle: one effort of a second in a shift of 8 h.
ONE_SECOND = 1 / 28_800
# Loads below this share of the strength count as rest (assumed, as the threshold of Eq. 2); the formula has none.
LEAST_SHARE = 0.1
# Under a load without any rest the formula allows nothing; 1 % keeps the ratio finite (assumed).
LEAST = 0.01


def acceptable_effort(duty_cycle: Vector) -> Vector:
    """The largest acceptable effort, as a share of the strength, at shares of the time under load; LEAST or more."""
    return np.asarray(np.maximum(1 - np.maximum(duty_cycle - ONE_SECOND, 0) ** 0.24, LEAST))


class AcceptableEffort(Indicator):
    """The largest effort of any joint over the one that is acceptable for as long as it lasts in the cycle.

    A load that changes is taken apart: it is at least x for a share of the cycle, and x has to be acceptable for that
    share, for every x (assumed; of a steady load it is the method's rule).
    """

    title: ClassVar[str] = "effort over the maximum acceptable effort"
    edition: ClassVar[str] = "Potvin 2012, 8 h"
    origin: ClassVar[Origin] = Origin.RECALLED

    kind: Literal["acceptable_effort"] = Field(
        default="acceptable_effort", description="Effort over the maximum acceptable effort of Potvin (2012)."
    )

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        shares = [entry_shares(operation) for operation in job.operations]
        load = np.vstack(shares)
        seconds = np.concatenate([
            np.full(len(share), operation.seconds_per_cycle / len(share))
            for share, operation in zip(shares, job.operations, strict=True)
        ])  # fmt: skip
        order = np.argsort(-load, axis=0, kind="stable")
        duty = np.minimum(np.cumsum(seconds[order], axis=0) / job.cycle_s, 1.0)
        sorted_load = np.take_along_axis(load, order, axis=0)
        allowed = acceptable_effort(duty)
        ratio = np.where(sorted_load >= LEAST_SHARE, sorted_load / allowed, 0.0)
        rank, entry = np.unravel_index(int(ratio.argmax()), ratio.shape)
        level = Level.ACCEPTABLE if ratio[rank, entry] <= 1 else Level.NOT_ACCEPTABLE
        row = int(order[0, entry])
        which = int(np.searchsorted(np.cumsum([len(share) for share in shares]), row, side="right"))
        instant = row - sum(len(share) for share in shares[:which])
        name = ENTRIES[int(entry)].split(":")[0]
        worst = Moment(
            operation=job.operations[which].name,
            time_s=float(job.operations[which].posture.time_s[instant]),
            side=next((one for one in SIDES if name.startswith(one)), ""),
            part=without_side(name).replace("_", " "),
        )
        found = float(ratio[rank, entry])
        return self.answer(
            value=Span(found, found),
            digits=2,
            levels=(level, level),
            words=("acceptable for 8 h",) * 2 if level == Level.ACCEPTABLE else ("too much for 8 h",) * 2,
            worst=worst,
            parts={
                "effort": float(sorted_load[rank, entry]),
                "duty cycle": float(duty[rank, entry]),
                "acceptable effort": float(allowed[rank, entry]),
            },
            remarks=(
                Phrase("Loads below {least:g} % of the strength count as rest.", {"least": 100 * LEAST_SHARE}),
                Phrase("For 8 h; a pause between cycles counts only if the length of the cycle is stated."),
            ),
        )

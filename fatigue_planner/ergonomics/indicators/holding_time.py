"""How much of its endurance a joint uses up in the longest hold (Frey Law & Avin 2010; Sjøgaard 1986)."""

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.indicator import Indicator
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.posture import runs
from fatigue_planner.ergonomics.result import Assessment, Level, Moment, Origin, Phrase, Span
from fatigue_planner.fatigue.entries import ENTRIES, GROUP_OF
from fatigue_planner.human.skeleton import SIDES, without_side

Vector = NDArray[np.float64]

# Endurance in s at a share of the strength: factor and exponent (Frey Law & Avin 2010). The wrist's is that of the
# grip; joints that are not named have the general one (both assumed, as for the rates in `fatigue/data/rates`).
ENDURANCE = {
    "general": (21.92, -1.98), "ankle": (34.71, -2.06), "back": (22.69, -2.27), "elbow": (17.98, -2.21),
    "wrist": (33.55, -1.61), "knee": (19.38, -1.88), "shoulder": (14.86, -1.83),
}  # fmt: skip
# Below this share of the strength the curves are not measured, and nothing is counted.
LEAST_SHARE = 0.15
# A hold is to use up a fifth of the endurance at most: 2 of 10 min, 1 of 5 (Miedema, Douwes & Dul 1997, abstract).
ADVISED = 0.2


def endurance_s(share: Vector, group: str) -> Vector:
    """How long a joint of a group can hold a share of its strength, in s; infinite below LEAST_SHARE."""
    factor, exponent = ENDURANCE.get(group, ENDURANCE["general"])
    time_s = factor * np.maximum(share, LEAST_SHARE) ** exponent
    return np.where(share < LEAST_SHARE, np.inf, time_s)


def sjogaard_s(share: Vector) -> Vector:
    """The same by Sjøgaard's curve for all joints: 5710 / (% of the strength)^2.14 min."""
    return np.where(share < LEAST_SHARE, np.inf, 60 * 5710 / (100 * np.maximum(share, LEAST_SHARE)) ** 2.14)


class HoldingTime(Indicator):
    """The largest share of its endurance that a joint uses up without a rest, once through the operation.

    While the load changes, each instant uses up its share of the endurance at its load. A range from the two curves.
    """

    title: ClassVar[str] = "share of the endurance used in a hold"
    edition: ClassVar[str] = "Frey Law & Avin 2010, by joint; Sjøgaard 1986, all joints"
    origin: ClassVar[Origin] = Origin.AGREED

    kind: Literal["holding_time"] = Field(
        default="holding_time", description="Share of the endurance that a hold uses up, by two published curves."
    )

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        best: tuple[float, float, Moment | None, str] = (-1.0, 0.0, None, "")
        highest = 0.0
        for operation in job.operations:
            for entry, share in zip(ENTRIES, entry_shares(operation).T, strict=True):
                for first, last in zip(*runs(share >= LEAST_SHARE), strict=True):
                    held = share[first:last]
                    by_joint = float((operation.posture.step_s / endurance_s(held, _group(entry))).sum())
                    by_all = float((operation.posture.step_s / sjogaard_s(held)).sum())
                    low, high = sorted((by_joint, by_all))
                    highest = max(highest, high)
                    if low > best[0]:
                        name = entry.split(":")[0]
                        side = next((one for one in SIDES if name.startswith(one)), "")
                        time_s = float(operation.posture.time_s[(first + last) // 2])
                        part = without_side(name).replace("_", " ")
                        best = low, high, Moment(operation.name, time_s, side, part), entry
        low, high = max(best[0], 0.0), highest
        levels = tuple(
            Level.NOT_ACCEPTABLE if used >= 1 else Level.INVESTIGATE if used > ADVISED else Level.ACCEPTABLE
            for used in (low, high)
        )
        words = ("within a fifth of the endurance", "more than a fifth of the endurance", "cannot be held")
        return self.answer(
            value=Span(100 * low, 100 * high),
            unit="%",
            levels=(levels[0], levels[1]),
            words=(words[levels[0]], words[levels[1]]),
            worst=best[2],
            remarks=(
                Phrase("Loads below {least:g} % of the strength count as rest.", {"least": 100 * LEAST_SHARE}),
                Phrase("Published curves of endurance differ by more than these two."),
            ),
        )


def entry_shares(operation: Operation) -> NDArray[np.float64]:
    """The load of each joint in each direction as a share of its strength, (n, 78), in the order of ENTRIES."""
    share = operation.torque_share
    return np.hstack([np.maximum(share, 0), np.maximum(-share, 0)])


def _group(entry: str) -> str:
    return without_side(GROUP_OF[entry])

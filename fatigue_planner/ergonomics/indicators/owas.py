"""OWAS, Ovako Working posture Analysing System (Karhu, Kansi & Kuorinka 1977, Applied Ergonomics 8, 199-201)."""

from collections.abc import Mapping
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Origin, Phrase
from fatigue_planner.ergonomics.scored_posture import ScoredPosture, Scores, one_foot
from fatigue_planner.ergonomics.stated import Circumstances

Integers = NDArray[np.int64]

# Back 1-4 with arms 1-3 each; along a row legs 1-7, of each the three classes of load. Of two cells transcriptions
# differ: 3.3.7.3 is 1 or 2, 4.1.3.2 is 2 or 3.
CATEGORIES = np.array([[int(digit) for digit in row.replace(" ", "")] for row in (
    "111 111 111 222 222 111 111", "111 111 111 222 222 111 111", "111 111 111 223 223 111 112",
    "223 223 223 333 333 222 233", "223 223 233 344 344 334 234", "334 223 333 344 444 444 234",
    "111 111 112 333 444 111 111", "223 111 112 444 444 333 111", "223 111 233 444 444 444 111",
    "233 223 223 444 444 444 234", "334 234 334 444 444 444 234", "444 234 334 444 444 444 234",
)]).reshape(4, 3, 7, 3)  # fmt: skip

STANDING, ONE_LEG, BOTH_BENT, ONE_BENT = 2, 3, 4, 5


def category(back: Integers, arms: Integers, legs: Integers, load: Integers) -> Integers:
    """The action category 1-4 of codes."""
    return np.asarray(CATEGORIES[back - 1, arms - 1, legs - 1, load - 1])


class Owas(ScoredPosture):
    """OWAS: the action category of each posture. The simulated worker stands: he does not sit, kneel or walk."""

    title: ClassVar[str] = "OWAS"
    edition: ClassVar[str] = "Karhu, Kansi & Kuorinka 1977; categories 3.3.7.3 as 1 and 4.1.3.2 as 2"
    origin: ClassVar[Origin] = Origin.AGREED
    bounds: ClassVar[tuple[int, int]] = (2, 3)
    words: ClassVar[Mapping[int, str]] = {
        1: "no corrective action needed",
        2: "corrective action in the near future",
        3: "corrective action as soon as possible",
        4: "corrective action immediately",
    }
    least_points: ClassVar[Mapping[str, int]] = {"back": 1, "arms": 1, "legs": 2}

    kind: Literal["owas"] = Field(default="owas", description="OWAS (Karhu, Kansi and Kuorinka 1977).")
    bent_deg: float = Field(
        default=20,
        gt=0,
        lt=90,
        description="From where on the back counts as bent, twisted or bent sideways, in degrees; the paper shows "
        "it in pictures.",
    )
    bent_knee_deg: float = Field(
        default=30, gt=0, lt=90, description="From where on a knee counts as bent, in degrees; as before."
    )

    def scores(self, operation: Operation, stated: Circumstances) -> Scores:
        """See ScoredPosture.scores."""
        seen = operation.posture
        bent = np.abs(seen.trunk_deg) > self.bent_deg
        turned = (np.abs(seen.trunk_twist_deg) > self.bent_deg) | (np.abs(seen.trunk_side_deg) > self.bent_deg)
        knees = seen.knee_deg > self.bent_knee_deg
        loaded = np.take_along_axis(knees, seen.foot_share.argmax(axis=1)[:, None], axis=1)[:, 0]
        on_one = np.where(loaded, ONE_BENT, ONE_LEG)
        codes = {
            "back": 1 + bent + 2 * turned,
            "arms": 1 + (seen.arm_raised_deg >= 90).sum(axis=1),
            "legs": np.where(one_foot(operation), on_one, np.where(knees.all(axis=1), BOTH_BENT, STANDING)),
            "load": load_class(operation.load_kg.sum(axis=1)),
        }
        found = category(**codes)
        return Scores(np.stack([found, found], axis=1), codes)

    def remarks(self, job: Job) -> tuple[Phrase, ...]:
        """See ScoredPosture.remarks."""
        return (
            Phrase(
                "Bent, twisted or bent sideways from {bent:g}°, knees from {knee:g}°: the paper has only pictures.",
                {"bent": self.bent_deg, "knee": self.bent_knee_deg},
            ),
        )


def load_class(load_kg: NDArray[np.float64]) -> Integers:
    """1 below 10 kg, 2 up to 20 kg, 3 above."""
    return np.asarray(1 + (load_kg >= 10).astype(np.int64) + (load_kg > 20))

"""REBA, Rapid Entire Body Assessment (Hignett & McAtamney 2000, Applied Ergonomics 31, 201-205)."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Origin, Phrase
from fatigue_planner.ergonomics.scored_posture import (
    REPEATED,
    REPEATED_PER_MINUTE,
    SHOCK,
    SHOULDER_RAISED,
    JointThresholds,
    Option,
    Scores,
    is_static,
    lower_arm_points,
    one_foot,
    upper_arm_points,
)
from fatigue_planner.ergonomics.stated import Circumstances

Integers = NDArray[np.int64]

# Neck 1-3; trunk 1-5, each with legs 1-4.
TABLE_A = np.array([
    [1, 2, 3, 4, 2, 3, 4, 5, 2, 4, 5, 6, 3, 5, 6, 7, 4, 6, 7, 8],
    [1, 2, 3, 4, 3, 4, 5, 6, 4, 5, 6, 7, 5, 6, 7, 8, 6, 7, 8, 9],
    [3, 3, 5, 6, 4, 5, 6, 7, 5, 6, 7, 8, 6, 7, 8, 9, 7, 8, 9, 9],
]).reshape(3, 5, 4)  # fmt: skip
# Upper arm 1-6; lower arm 1 and 2, each with wrist 1-3.
TABLE_B = np.array([
    [1, 2, 2, 1, 2, 3],
    [1, 2, 3, 2, 3, 4],
    [3, 4, 5, 4, 5, 5],
    [4, 5, 5, 5, 6, 7],
    [6, 7, 8, 7, 8, 8],
    [7, 8, 8, 8, 9, 9],
]).reshape(6, 2, 3)  # fmt: skip
# Score A 1-12, score B 1-12.
TABLE_C = np.array([
    [1, 1, 1, 2, 3, 3, 4, 5, 6, 7, 7, 7],
    [1, 2, 2, 3, 4, 4, 5, 6, 6, 7, 7, 8],
    [2, 3, 3, 3, 4, 5, 6, 7, 7, 8, 8, 8],
    [3, 4, 4, 4, 5, 6, 7, 8, 8, 9, 9, 9],
    [4, 4, 4, 5, 6, 7, 8, 8, 9, 9, 9, 9],
    [6, 6, 6, 7, 8, 8, 9, 9, 10, 10, 10, 10],
    [7, 7, 7, 8, 9, 9, 9, 10, 10, 11, 11, 11],
    [8, 8, 8, 9, 10, 10, 10, 10, 10, 11, 11, 11],
    [9, 9, 9, 10, 10, 10, 11, 11, 11, 12, 12, 12],
    [10, 10, 10, 11, 11, 11, 11, 12, 12, 12, 12, 12],
    [11, 11, 11, 11, 12, 12, 12, 12, 12, 12, 12, 12],
    [12, 12, 12, 12, 12, 12, 12, 12, 12, 12, 12, 12],
])  # fmt: skip
COUPLING = {"good": 0, "fair": 1, "poor": 2, "unacceptable": 3}
# An upper arm this near to hanging, away from a bent trunk, is helped by gravity, in degrees (assumed).
HANGING_DEG = 20.0


def table_a(neck: Integers, trunk: Integers, legs: Integers) -> Integers:
    """Score A, without the load, from points."""
    return np.asarray(TABLE_A[neck - 1, trunk - 1, legs - 1])


def table_b(upper_arm: Integers, lower_arm: Integers, wrist: Integers) -> Integers:
    """Score B, without the coupling, from points."""
    return np.asarray(TABLE_B[upper_arm - 1, lower_arm - 1, wrist - 1])


def table_c(a: Integers, b: Integers) -> Integers:
    """Score C from scores A and B, 1 and more."""
    return np.asarray(TABLE_C[np.minimum(a, 12) - 1, np.minimum(b, 12) - 1])


class Reba(JointThresholds):
    """REBA for both sides: the worse one counts."""

    title: ClassVar[str] = "REBA"
    edition: ClassVar[str] = "Hignett & McAtamney 2000; twist and side bend are one point together; static from 1 min"
    origin: ClassVar[Origin] = Origin.AGREED
    bounds: ClassVar[tuple[int, int]] = (2, 8)
    words: ClassVar[Mapping[int, str]] = {
        1: "negligible risk",
        2: "low risk; a change may be necessary",
        4: "medium risk; a change is necessary",
        8: "high risk; a change is necessary soon",
        11: "very high risk; a change is necessary now",
    }
    least_points: ClassVar[Mapping[str, int]] = dict.fromkeys(
        ("trunk", "neck", "legs", "upper arm", "lower arm", "wrist"), 1
    )

    kind: Literal["reba"] = Field(default="reba", description="REBA (Hignett & McAtamney 2000).")

    def options(self, operation: Operation) -> Sequence[Option]:
        """See ScoredPosture.options."""
        unknown = [
            REPEATED,
            SHOCK,
            SHOULDER_RAISED,
            Option("rapid_changes", True, Phrase("with rapid large changes of posture or an unstable base")),
        ]
        if operation.load_kg.any():
            unknown += [
                Option("coupling", "fair", Phrase("with fair coupling")),
                Option("coupling", "poor", Phrase("with poor coupling")),
                Option("coupling", "unacceptable", Phrase("with unacceptable coupling")),
            ]
        return [option for option in unknown if getattr(operation.stated, option.key) is None]

    def scores(self, operation: Operation, stated: Circumstances) -> Scores:
        """See ScoredPosture.scores."""
        body, arm = self.body_points(operation), self.arm_points(operation, stated)
        load_kg = operation.load_kg.sum(axis=1)
        force = (load_kg >= 5).astype(np.int64) + (load_kg > 10) + bool(stated.shock)
        coupling = np.where(operation.load_kg > 0, COUPLING[stated.coupling or "good"], 0)
        a = table_a(**body) + force
        b = table_b(**arm) + coupling
        repeated = (stated.actions_per_minute or 0) > REPEATED_PER_MINUTE
        activity = np.full(len(a), int(is_static(operation)) + int(repeated) + int(bool(stated.rapid_changes)))
        c = table_c(a[:, None], b)
        points = {name.replace("_", " "): values for name, values in (body | arm).items()}
        more = {"force": force, "coupling": coupling, "activity": activity}
        return Scores(c + activity[:, None], points | more | {"score A": a, "score B": b, "score C": c})

    def body_points(self, operation: Operation) -> dict[str, Integers]:
        """Points (n,) of neck, trunk and legs."""
        seen = operation.posture
        neck = np.where(seen.neck_deg < -self.tolerance_deg, 2, 1 + (seen.neck_deg > 20))
        away = np.abs(seen.trunk_deg)
        trunk = 1 + (away > self.tolerance_deg).astype(np.int64) + (away > 20) + (seen.trunk_deg > 60)
        knee = seen.knee_deg.max(axis=1)
        return {
            "neck": neck + np.logical_or(*self.turned(seen.neck_twist_deg, seen.neck_side_deg)),
            "trunk": trunk + np.logical_or(*self.turned(seen.trunk_twist_deg, seen.trunk_side_deg)),
            "legs": 1 + one_foot(operation).astype(np.int64) + (knee >= 30) + (knee > 60),
        }

    def arm_points(self, operation: Operation, stated: Circumstances) -> dict[str, Integers]:
        """Points (n, 2) of upper arm, lower arm and wrist."""
        seen = operation.posture
        hangs = (seen.arm_raised_deg <= HANGING_DEG) & (np.abs(seen.arm_to_trunk_deg) > HANGING_DEG)
        upper = upper_arm_points(seen.arm_to_trunk_deg) + (seen.arm_abducted_deg > self.abducted_deg)
        upper = (
            upper
            + (operation.works & bool(stated.shoulder_raised))
            - (hangs | (operation.works & stated.arm_supported))
        )
        return {
            "upper_arm": np.clip(upper, 1, 6),
            "lower_arm": lower_arm_points(seen.elbow_deg),
            "wrist": 1 + (np.abs(seen.wrist_deg) > 15) + (np.abs(seen.deviation_deg) > self.deviated_deg),
        }

    def remarks(self, job: Job) -> tuple[Phrase, ...]:
        """See ScoredPosture.remarks."""
        gravity = Phrase(
            "An upper arm within {hanging:g}° of the vertical under a bent trunk is helped by gravity; its rotation "
            "and a twist of the wrist are not counted.",
            {"hanging": HANGING_DEG},
        )
        return (*super().remarks(job), gravity)

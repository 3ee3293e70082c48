"""RULA, Rapid Upper Limb Assessment (McAtamney & Corlett 1993, Applied Ergonomics 24, 91-99)."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.ergonomics.operation import Operation
from fatigue_planner.ergonomics.result import Origin
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
from fatigue_planner.human.joint_data import ranges_of_motion

Integers = NDArray[np.int64]

# Upper arm 1-6, lower arm 1-3; then wrist 1-4, each with twist 1 and 2.
TABLE_A = np.array([
    [[1, 2, 2, 2, 2, 3, 3, 3], [2, 2, 2, 2, 3, 3, 3, 3], [2, 3, 3, 3, 3, 3, 4, 4]],
    [[2, 3, 3, 3, 3, 4, 4, 4], [3, 3, 3, 3, 3, 4, 4, 4], [3, 4, 4, 4, 4, 4, 5, 5]],
    [[3, 3, 4, 4, 4, 4, 5, 5], [3, 4, 4, 4, 4, 4, 5, 5], [4, 4, 4, 4, 4, 5, 5, 5]],
    [[4, 4, 4, 4, 4, 5, 5, 5], [4, 4, 4, 4, 4, 5, 5, 5], [4, 4, 4, 5, 5, 5, 6, 6]],
    [[5, 5, 5, 5, 5, 6, 6, 7], [5, 6, 6, 6, 6, 7, 7, 7], [6, 6, 6, 7, 7, 7, 7, 8]],
    [[7, 7, 7, 7, 7, 8, 8, 9], [8, 8, 8, 8, 8, 9, 9, 9], [9, 9, 9, 9, 9, 9, 9, 9]],
]).reshape(6, 3, 4, 2)  # fmt: skip
# Neck 1-6; trunk 1-6, each with legs 1 and 2.
TABLE_B = np.array([
    [1, 3, 2, 3, 3, 4, 5, 5, 6, 6, 7, 7],
    [2, 3, 2, 3, 4, 5, 5, 5, 6, 7, 7, 7],
    [3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 7],
    [5, 5, 5, 6, 6, 7, 7, 7, 7, 7, 8, 8],
    [7, 7, 7, 7, 7, 8, 8, 8, 8, 8, 8, 8],
    [8, 8, 8, 8, 8, 8, 8, 9, 9, 9, 9, 9],
]).reshape(6, 6, 2)  # fmt: skip
# Score C 1-8 and more, score D 1-7 and more.
TABLE_C = np.array([
    [1, 2, 3, 3, 4, 5, 5],
    [2, 2, 3, 4, 4, 5, 5],
    [3, 3, 3, 4, 4, 5, 6],
    [3, 3, 3, 4, 5, 6, 6],
    [4, 4, 4, 5, 6, 7, 7],
    [4, 4, 5, 6, 6, 7, 7],
    [5, 5, 6, 6, 7, 7, 7],
    [5, 5, 6, 7, 7, 7, 7],
])  # fmt: skip

# Twist of the wrist is near the end of its range from this share of it on (assumed; the paper gives no number).
NEAR_END = 0.75
# The hand works out to the side of the body from this far beyond the shoulder, in m (assumed).
OUT_TO_SIDE_M = 0.25


def table_a(upper_arm: Integers, lower_arm: Integers, wrist: Integers, twist: Integers) -> Integers:
    """Score A from points."""
    return np.asarray(TABLE_A[upper_arm - 1, lower_arm - 1, wrist - 1, twist - 1])


def table_b(neck: Integers, trunk: Integers, legs: Integers) -> Integers:
    """Score B from points."""
    return np.asarray(TABLE_B[neck - 1, trunk - 1, legs - 1])


def table_c(c: Integers, d: Integers) -> Integers:
    """The grand score from scores C and D, 1 and more."""
    return np.asarray(TABLE_C[np.minimum(c, 8) - 1, np.minimum(d, 7) - 1])


class Rula(JointThresholds):
    """RULA for both sides: the worse one counts. The force of a load counts for the arm that bears it."""

    title: ClassVar[str] = "RULA"
    edition: ClassVar[str] = (
        "McAtamney & Corlett 1993; table A of the widespread worksheet; upper arm neutral to 20°; static from 1 min"
    )
    origin: ClassVar[Origin] = Origin.AGREED
    bounds: ClassVar[tuple[int, int]] = (3, 5)
    words: ClassVar[Mapping[int, str]] = {
        1: "acceptable if not held or repeated for long",
        3: "investigate further; change may be needed",
        5: "investigate further and change soon",
        7: "investigate and change immediately",
    }
    least_points: ClassVar[Mapping[str, int]] = dict.fromkeys(
        ("trunk", "neck", "upper arm", "lower arm", "wrist", "legs"), 1
    )

    kind: Literal["rula"] = Field(default="rula", description="RULA (McAtamney & Corlett 1993).")

    def options(self, operation: Operation) -> Sequence[Option]:
        """See ScoredPosture.options."""
        unknown = (SHOCK, SHOULDER_RAISED) if is_static(operation) else (REPEATED, SHOCK, SHOULDER_RAISED)
        return [option for option in unknown if getattr(operation.stated, option.key) is None]

    def scores(self, operation: Operation, stated: Circumstances) -> Scores:
        """See ScoredPosture.scores."""
        arm = self.arm_points(operation, stated)
        body = self.body_points(operation)
        a, b = table_a(**arm), table_b(**body)
        static = is_static(operation) or (stated.actions_per_minute or 0) > REPEATED_PER_MINUTE
        load_kg = operation.load_kg
        muscle = np.full(len(b), int(static))
        force_a = self.force_points(load_kg, static, operation.works & bool(stated.shock))
        force_b = self.force_points(load_kg.sum(axis=1), static, np.array(bool(stated.shock)))
        c, d = a + muscle[:, None] + force_a, b + muscle + force_b
        points = {name.replace("_", " "): values for name, values in (arm | body).items()}
        more = {"muscle": muscle, "force of the arm": force_a, "force of both": force_b}
        scores = {"score A": a, "score B": b, "score C": c, "score D": d}
        return Scores(table_c(c, d[:, None]), points | more | scores)

    def arm_points(self, operation: Operation, stated: Circumstances) -> dict[str, Integers]:
        """Points (n, 2) of upper arm, lower arm, wrist and twist of the wrist."""
        seen = operation.posture
        upper = upper_arm_points(seen.arm_to_trunk_deg) + (seen.arm_abducted_deg > self.abducted_deg)
        upper = upper + (operation.works & bool(stated.shoulder_raised)) - (operation.works & stated.arm_supported)
        across = seen.hand_out_m < 0
        out = seen.hand_out_m > seen.shoulder_half_width_m + OUT_TO_SIDE_M
        bent = np.abs(seen.wrist_deg)
        wrist = 1 + (bent > self.tolerance_deg) + (bent > 15) + (np.abs(seen.deviation_deg) > self.deviated_deg)
        turn = ranges_of_motion()["forearm_pronation"]
        end = np.where(seen.pronation_deg > 0, turn.max, -turn.min)
        return {
            "upper_arm": np.clip(upper, 1, 6),
            "lower_arm": lower_arm_points(seen.elbow_deg) + (across | out),
            "wrist": wrist,
            "twist": 1 + (np.abs(seen.pronation_deg) >= NEAR_END * end),
        }

    def body_points(self, operation: Operation) -> dict[str, Integers]:
        """Points (n,) of neck, trunk and legs."""
        seen = operation.posture
        neck = np.where(seen.neck_deg < -self.tolerance_deg, 4, 1 + (seen.neck_deg > 10) + (seen.neck_deg > 20))
        trunk = 1 + (np.abs(seen.trunk_deg) > self.tolerance_deg) + (seen.trunk_deg > 20) + (seen.trunk_deg > 60)
        return {
            "neck": neck + sum(self.turned(seen.neck_twist_deg, seen.neck_side_deg)),
            "trunk": trunk + sum(self.turned(seen.trunk_twist_deg, seen.trunk_side_deg)),
            "legs": 1 + one_foot(operation),
        }

    @staticmethod
    def force_points(load_kg: NDArray[np.float64], static: bool, shock: NDArray[np.bool_]) -> Integers:
        """Points of loads in kg: 3 where there are shocks; else below 2 kg 0, to 10 kg 1, above 2; if static, 1 more.

        Many worksheets leave out the 2 points of more than 10 kg held now and then.
        """
        over = (load_kg >= 2).astype(np.int64) + (load_kg > 10)
        return np.asarray(np.where(shock, 3, np.where(over > 0, over + int(static), 0)))

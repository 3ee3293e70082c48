"""A body with lengths of its own, and with its trunk's mass where its own landmarks, and plates, say."""

from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry, Segment, segment_table
from fatigue_planner.human.multibody import multibody
from fatigue_planner.human.skeleton import SIDES, without_side
from fatigue_planner.recordings.mapping import landmark_table

Vector = NDArray[np.float64]

# Which factor stretches which joint's centre, per axis of its parent; the other axes are 1.
SEGMENTS = ("trunk", "shoulder_width", "upper_arm", "forearm", "hip_width", "thigh", "shank")
STRETCHED: dict[str, tuple[tuple[int, str], ...]] = {
    "lumbar": ((2, "trunk"),),
    "thoracic": ((2, "trunk"),),
    "neck": ((2, "trunk"),),
    "head": (),
    "shoulder": ((1, "shoulder_width"), (2, "trunk")),
    "elbow": ((2, "upper_arm"),),
    "wrist": ((2, "forearm"),),
    "hip": ((1, "hip_width"),),
    "knee": ((2, "thigh"),),
    "ankle": ((2, "shank"),),
}
_LENGTHS = {
    "upper_arm_length": "upper_arm",
    "forearm_length": "forearm",
    "thigh_length": "thigh",
    "shank_length": "shank",
}


# Bodies of the trunk with de Leva's rows, from the mid-hip upwards; what sits on it moves with its mass line.
_TRUNK = {"pelvis": "lower_trunk", "abdomen": "mid_trunk", "thorax": "upper_trunk"}
_ABOVE_PELVIS = ("abdomen", "thorax", "neck", "head")


@dataclass(frozen=True)
class Measured(Anthropometry):
    """A body of which each of `SEGMENTS` is `factors` (7,) times as long as the stature says.

    cervicale_m: how high the seventh cervical vertebra is above the mid-hip, if a marker showed it: de Leva's landmark,
    by which his segments of the trunk, and the head above them, are placed; by the stature, if not. trunk_forward_m:
    how far the masses above the pelvis are in front of the joints (see `dynamics.balanced`).
    """

    factors: tuple[float, ...] = field(default=(1.0,) * len(SEGMENTS))
    cervicale_m: float | None = None
    trunk_forward_m: float = 0.0

    def factor(self, segment: str) -> float:
        """How many times as long a segment is."""
        return self.factors[SEGMENTS.index(segment)]

    def length(self, name: str) -> float:
        """As for any body, with the limbs' own lengths."""
        return super().length(name) * (self.factor(_LENGTHS[name]) if name in _LENGTHS else 1.0)

    def joint_centre(self, joint: str) -> Vector:
        """As for any body, stretched."""
        usual = Anthropometry(self.stature_m, self.mass_kg, self.sex, self.human).joint_centre(joint)
        for axis, segment in STRETCHED[without_side(joint)]:
            usual[axis] *= self.factor(segment)
        return usual

    def segment(self, body: str) -> Segment:
        """As for any body, with the trunk's masses at the heights of its own landmarks."""
        usual = super().segment(body)
        com = usual.com_m.copy()
        if self.cervicale_m is not None and body in (*_TRUNK, "head"):
            com[2] = self._mass_height(body, self.cervicale_m) - self.above_hip(body)
        if body in _ABOVE_PELVIS:
            com[0] += self.trunk_forward_m
        return replace(usual, com_m=com)

    def above_hip(self, body: str) -> float:
        """Height of a trunk body's frame, of the neck's or of the head's above the mid-hip, standing straight."""
        order = ("lumbar", "thoracic", "neck", "head")
        return float(sum(self.joint_centre(joint)[2] for joint in order[: ("pelvis", *_ABOVE_PELVIS).index(body)]))

    def _mass_height(self, body: str, cervicale_m: float) -> float:
        """Height of a mass centre above the mid-hip: de Leva's segments, stretched to reach the cervicale."""
        rows = {name: row[self.sex] for name, row in segment_table().segments.items()}
        if body == "head":  # the vertex is as far above the cervicale as the stature says
            table = landmark_table()
            usual = Anthropometry(self.stature_m, self.mass_kg, self.sex, self.human)
            usual_m = usual.origin_height("thorax") + table.landmarks["c7"].at_m[2] * self.stature_m / table.stature_m
            length = rows["head"].length_m / segment_table().reference_stature_m[self.sex] * self.stature_m
            return cervicale_m + self.stature_m - usual_m - rows["head"].com_percent / 100 * length
        whole, top = sum(rows[row].length_m for row in _TRUNK.values()), 0.0
        for name, row in _TRUNK.items():
            top += rows[row].length_m
            if name == body:
                break
        return cervicale_m / whole * (top - rows[row].com_percent / 100 * rows[row].length_m)

    def model(self, right_hand_kg: float = 0.0, left_hand_kg: float = 0.0) -> pin.Model:
        """The body as a Pinocchio model, with point masses at the centres of the fists."""
        found = multibody(self)
        for side, mass in zip(SIDES, (right_hand_kg, left_hand_kg), strict=True):
            grip = found.frames[found.getFrameId(f"{side}_grip")]
            found.appendBodyToJoint(grip.parentJoint, pin.Inertia(mass, np.zeros(3), np.zeros((3, 3))), grip.placement)
        return found

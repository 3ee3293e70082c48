"""A body with lengths of its own: segments that are longer or shorter than the stature says."""

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.multibody import multibody
from fatigue_planner.human.skeleton import SIDES, without_side

Vector = NDArray[np.float64]

# Which factor stretches which joint's centre, per axis of its parent; the other axes are 1.
SEGMENTS = ("trunk", "shoulder_width", "upper_arm", "forearm", "hip_width", "thigh", "shank")
STRETCHED: dict[str, tuple[tuple[int, str], ...]] = {
    "lumbar": ((2, "trunk"),),
    "thoracic": ((2, "trunk"),),
    "neck": ((2, "trunk"),),
    "head": ((2, "trunk"),),
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


@dataclass(frozen=True)
class Measured(Anthropometry):
    """A body of which each of `SEGMENTS` is `factors` (7,) times as long as the stature says."""

    factors: tuple[float, ...] = field(default=(1.0,) * len(SEGMENTS))

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

    def model(self, right_hand_kg: float = 0.0, left_hand_kg: float = 0.0) -> pin.Model:
        """The body as a Pinocchio model, with point masses at the centres of the fists."""
        found = multibody(self)
        for side, mass in zip(SIDES, (right_hand_kg, left_hand_kg), strict=True):
            grip = found.frames[found.getFrameId(f"{side}_grip")]
            found.appendBodyToJoint(grip.parentJoint, pin.Inertia(mass, np.zeros(3), np.zeros((3, 3))), grip.placement)
        return found

"""An upper arm raised above an angle."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.human.model import Human
from fatigue_planner.motion.motion import Motion
from fatigue_planner.reactions.posture_costs.posture_cost import PostureCost, angles_deg, positions_m


class UpperArmRaised(PostureCost):
    """An upper arm, of either side, farther from hanging than an angle (ISO 11226: not acceptable above 60 degrees)."""

    kind: Literal["upper_arm_raised"] = Field(description="An upper arm raised above an angle, of either side.")
    angle_deg: float = Field(
        default=60.0,
        gt=0,
        lt=180,
        description="Angle of the upper arm from hanging, in degrees, above which it counts; 60 is ISO 11226's limit.",
    )

    def taken(self, human: Human, motion: Motion) -> NDArray[np.bool_]:
        """See PostureCost.taken."""
        sides = ("right", "left")
        points = positions_m(human, motion, [f"{side}_{body}" for body in ("upper_arm", "forearm") for side in sides])
        return np.asarray((angles_deg(points[:, 2:] - points[:, :2], -1) > self.angle_deg).any(axis=1))

"""A trunk bent beyond an angle."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.human.model import Human
from fatigue_planner.motion.motion import Motion
from fatigue_planner.reactions.posture_costs.posture_cost import PostureCost, angles_deg, positions_m


class TrunkBent(PostureCost):
    """The line from mid-hip to C7 farther from upright than an angle (ISO 11226: not acceptable above 60 degrees)."""

    kind: Literal["trunk_bent"] = Field(
        description="The trunk, from mid-hip to C7, bent beyond an angle, in any direction."
    )
    angle_deg: float = Field(
        default=60.0,
        gt=0,
        lt=180,
        description="Angle of the trunk from upright, in degrees, beyond which it counts; 60 is ISO 11226's limit.",
    )

    def taken(self, human: Human, motion: Motion) -> NDArray[np.bool_]:
        """See PostureCost.taken."""
        right_hip, left_hip, neck = np.moveaxis(positions_m(human, motion, ["right_thigh", "left_thigh", "neck"]), 1, 0)
        return np.asarray(angles_deg(neck - (right_hip + left_hip) / 2, 1) > self.angle_deg)

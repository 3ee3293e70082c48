"""The kinds of posture costs.

A new kind is a file beside this one and a name in KINDS; from outside the package, `fatigue_planner.register`.
"""

from typing import Annotated

from fatigue_planner.core.plugins import Registry
from fatigue_planner.reactions.posture_costs.posture_cost import PostureCost
from fatigue_planner.reactions.posture_costs.trunk_bent import TrunkBent
from fatigue_planner.reactions.posture_costs.upper_arm_raised import UpperArmRaised

POSTURE_COSTS = Registry("posture cost", PostureCost)  # type: ignore[type-abstract]
KINDS = (UpperArmRaised, TrunkBent)
for kind in KINDS:
    POSTURE_COSTS.add(kind)

# The settings of any posture cost.
AnyPostureCost = Annotated[PostureCost, POSTURE_COSTS]

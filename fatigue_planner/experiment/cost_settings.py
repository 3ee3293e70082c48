"""What an experiment says of costs: what the robot minimises, and a worker's expertise compares (Eqs. 4 and 5)."""

from typing import Annotated

import numpy as np
from pydantic import Field

from fatigue_planner.core.settings import Settings
from fatigue_planner.fatigue.entries import ENTRIES, entry_indices
from fatigue_planner.human.model import Human
from fatigue_planner.motion.motion import Motion
from fatigue_planner.pomdp.cost import CostKind, FatigueCost
from fatigue_planner.reactions.posture_costs.registry import AnyPostureCost

Weight = Annotated[float, Field(ge=0, le=10)]


class CostSettings(Settings):
    """What a state costs; without a word it is the paper's mean square of fatigue."""

    fatigue: CostKind = Field(
        default="mean_square",
        description="How the fatigue of the joints becomes a cost: the mean of its squares (mean_square; paper, Eq. 5) "
        "or the highest (worst_joint).",
    )
    weights: dict[str, Weight] = Field(
        default_factory=dict,
        max_length=1000,
        description="Weights of joints, without unit, from 0 (does not count) to 10: by entry "
        "(lumbar_flexion:negative), degree of freedom (lumbar_flexion), joint (back), any of them without its side, or "
        "all; a later one counts. Default: 1 for all.",
    )
    posture: tuple[AnyPostureCost, ...] = Field(
        default=(), max_length=20, description="What postures of a reaction cost besides. Default: nothing."
    )

    def fatigue_cost(self) -> FatigueCost:
        """The cost of fatigue. Raises DataFileError for an unknown joint."""
        weights = np.ones(len(ENTRIES))
        for name, weight in self.weights.items():
            weights[entry_indices(name, f"cost.weights.{name}")] = weight
        return FatigueCost(self.fatigue, weights)

    def posture_cost(self, human: Human, motion: Motion) -> float:
        """What the postures of a motion cost."""
        return sum((posture.of(human, motion) for posture in self.posture), 0.0)

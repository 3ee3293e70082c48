"""The choice model `boltzmann`: the paper's Eq. 4."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from pydantic import Field

from fatigue_planner.pomdp.choices.choice_model import Array, ChoiceModel


class BoltzmannChoice(ChoiceModel):
    """Only costs count (paper, Eq. 4)."""

    kind: Literal["boltzmann"] = Field(description="Only what reactions cost counts (paper, Eq. 4).")

    def log_odds(self, preferences: Sequence[str]) -> Array:
        """See ChoiceModel.log_odds."""
        return np.zeros((1, len(preferences)))

"""The choice model `inertia`: who has chosen a preference is likely to choose it again.

Of 39 people who lifted a hundred times each, 4 changed between semi-squat and stoop (Burgess-Limerick & Abernethy 1997,
"Qualitatively different modes of manual lifting", Int J Ind Ergon 19:413; its abstract was read).
"""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from pydantic import Field

from fatigue_planner.pomdp.choices.choice_model import Array, ChoiceModel, LogOdds, Offsets, offsets_of


class InertiaChoice(ChoiceModel):
    """Log-odds for the preference of the cycle before, whatever the action; and an offset per preference."""

    kind: Literal["inertia"] = Field(description="The preference of the cycle before is likelier than its cost says.")
    inertia: LogOdds = Field(
        description="Log-odds that are added to -beta c of Eq. 4 for the preference of the cycle before, without unit; "
        "negative for who likes change."
    )
    offsets: Offsets = Field(
        default_factory=dict, description="As of the kind `offset`: log-odds by preference. Default: 0 for all."
    )

    def log_odds(self, preferences: Sequence[str]) -> Array:
        """See ChoiceModel.log_odds."""
        habit = np.vstack([np.zeros(len(preferences)), self.inertia * np.eye(len(preferences))])
        return np.asarray(offsets_of(self.offsets, preferences) + habit)

    def preferences_named(self) -> Mapping[str, Sequence[str]]:
        """See ChoiceModel.preferences_named."""
        return {"offsets": tuple(self.offsets)}

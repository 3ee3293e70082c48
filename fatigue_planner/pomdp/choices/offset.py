"""The choice model `offset`: some preferences are liked more than their costs say, always."""

from collections.abc import Mapping, Sequence
from typing import Literal

from pydantic import Field

from fatigue_planner.pomdp.choices.choice_model import Array, ChoiceModel, Offsets, offsets_of


class OffsetChoice(ChoiceModel):
    """An offset per preference (an alternative-specific constant)."""

    kind: Literal["offset"] = Field(description="Every preference has an offset besides its cost.")
    offsets: Offsets = Field(
        description="Log-odds that are added to -beta c of Eq. 4, by preference, without unit: ln 2 makes a preference "
        "twice as likely, against one without offset. Left out: 0. Only differences count."
    )

    def log_odds(self, preferences: Sequence[str]) -> Array:
        """See ChoiceModel.log_odds."""
        return offsets_of(self.offsets, preferences)

    def preferences_named(self) -> Mapping[str, Sequence[str]]:
        """See ChoiceModel.preferences_named."""
        return {"offsets": tuple(self.offsets)}

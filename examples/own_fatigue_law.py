"""A fatigue law of your own: Ma's law without a threshold, in which a joint recovers under any load.

As a plug-in (`fatplan benchmark mine.yaml --plugin examples/own_fatigue_law.py`) an experiment file can name it:
`fatigue: {law: {kind: ma_always_recovering, recovery_under_load: 0.5}}`.
"""

from typing import Literal

import numpy as np
from pydantic import Field

import fatigue_planner as fp
from fatigue_planner.fatigue.laws.law import Rates
from fatigue_planner.fatigue.model import Flows


@fp.register
class AlwaysRecoveringLaw(fp.FatigueLaw):
    """df/dt = k s (1 - f) - c R f with the load s, c = 1 without a load and `recovery_under_load` with any."""

    kind: Literal["ma_always_recovering"]
    recovery_under_load: float = Field(default=1.0, ge=0, le=1, description="What is left of R under a load, no unit.")

    @property
    def rates_of(self) -> str:
        """See FatigueLaw.rates_of: the paper's k and R, or a set of them."""
        return "ma"

    def flows(self, share: np.ndarray, rates: Rates) -> Flows:
        """See FatigueLaw.flows: df/dt = k a - (k b + R c) f."""
        return Flows(share, share, np.where(share > 0, self.recovery_under_load, 1.0))

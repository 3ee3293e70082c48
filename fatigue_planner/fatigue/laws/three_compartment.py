"""The three-compartment controller with rest recovery, 3CC-r (Xia & Frey Law 2008; Frey Law 2012; Looft 2018)."""

from typing import Literal

import numpy as np
from pydantic import Field

from fatigue_planner.fatigue.laws.law import FatigueLaw, Matrix, Rates
from fatigue_planner.fatigue.model import Flows


class ThreeCompartmentLaw(FatigueLaw):
    """3CC-r where the load can be met: df/dt = F s - R f under a load s above the threshold, else df/dt = -r R f.

    Muscle is active (M_A), fatigued (M_F = f) or resting (M_R). A controller keeps M_A at the load s; then
    dM_F/dt = F M_A - R M_F is affine in M_F. Left out is the lag of the controller, a tenth of a second.
    """

    kind: Literal["3cc_r"] = Field(
        description="Three-compartment controller with rest recovery (Looft et al. 2018), with its F, R and r."
    )

    @property
    def rests_faster(self) -> bool:
        """See FatigueLaw.rests_faster."""
        return True

    def flows(self, share: Matrix, rates: Rates) -> Flows:
        """See FatigueLaw.flows."""
        loaded = share > rates.threshold
        return Flows(np.where(loaded, share, 0.0), np.zeros_like(share), np.where(loaded, 1.0, rates.rest_multiplier))

"""The kinds of indicators, and all of them on one job.

A new kind is a file in `indicators` and a name in KINDS; from outside the package, `fatigue_planner.register`.
"""

from collections.abc import Sequence
from typing import Annotated

from fatigue_planner.ergonomics.indicator import INDICATORS, Indicator
from fatigue_planner.ergonomics.indicators.acceptable_effort import AcceptableEffort
from fatigue_planner.ergonomics.indicators.arm_force_field import ArmForceField
from fatigue_planner.ergonomics.indicators.cumulative_strain_index import CumulativeStrainIndex
from fatigue_planner.ergonomics.indicators.duet import Duet
from fatigue_planner.ergonomics.indicators.en_1005_4 import En10054
from fatigue_planner.ergonomics.indicators.holding_time import HoldingTime
from fatigue_planner.ergonomics.indicators.iso_11226 import Iso11226
from fatigue_planner.ergonomics.indicators.l5s1_compression import L5S1Compression
from fatigue_planner.ergonomics.indicators.lm_mmh import LibertyMutual
from fatigue_planner.ergonomics.indicators.niosh_lifting import NioshLifting
from fatigue_planner.ergonomics.indicators.owas import Owas
from fatigue_planner.ergonomics.indicators.percent_capable import PercentCapable
from fatigue_planner.ergonomics.indicators.reba import Reba
from fatigue_planner.ergonomics.indicators.rula import Rula
from fatigue_planner.ergonomics.indicators.strain_index import StrainIndex
from fatigue_planner.ergonomics.operation import Job, Operation
from fatigue_planner.ergonomics.result import Assessment
from fatigue_planner.ergonomics.stated import Shift

KINDS = (
    Rula, Reba, Iso11226, En10054, Owas, NioshLifting, PercentCapable, AcceptableEffort, HoldingTime, L5S1Compression,
    ArmForceField, LibertyMutual, StrainIndex, CumulativeStrainIndex, Duet,
)  # fmt: skip
for kind in KINDS:
    INDICATORS.add(kind)

# The settings of any indicator.
AnyIndicator = Annotated[Indicator, INDICATORS]


def evaluate(
    operations: Sequence[Operation], shift: Shift | None = None, indicators: Sequence[Indicator] | None = None
) -> tuple[Assessment, ...]:
    """What indicators say of the operations of a cycle; all indicators by default, in the order of the registry.

    Raises DataFileError if the operations take longer than the cycle.
    """
    job = Job(tuple(operations), shift or Shift())
    chosen = [kind(kind=name) for name, kind in INDICATORS.kinds().items()] if indicators is None else indicators
    return tuple(indicator.assess(job) for indicator in chosen)

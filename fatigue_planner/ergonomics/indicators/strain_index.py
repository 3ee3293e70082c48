"""The revised strain index of each working hand; of several operations, the composite one."""

from collections.abc import Sequence
from typing import ClassVar, Literal

from pydantic import Field

from fatigue_planner.ergonomics.hand_strain import HandStrain
from fatigue_planner.ergonomics.result import Origin
from fatigue_planner.ergonomics.stated import Shift
from fatigue_planner.ergonomics.strain_equation import Effort, composite_index


class StrainIndex(HandStrain):
    """The strain index of the worse hand in this work alone."""

    title: ClassVar[str] = "revised strain index"
    edition: ClassVar[str] = (
        "Garg, Moore & Kapellusch 2017; several operations: composite index (COSI); the limit of 10 is recalled"
    )
    origin: ClassVar[Origin] = Origin.RECALLED

    kind: Literal["strain_index"] = Field(
        default="strain_index", description="Revised strain index and its composite (Garg, Moore and Kapellusch 2017)."
    )

    def index(self, efforts: Sequence[Effort], hours: float, shift: Shift) -> float:
        """See HandStrain.index."""
        return composite_index(efforts, hours)

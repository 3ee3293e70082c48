"""The cumulative strain index: what the hands do in the whole shift, at this work and at others."""

from collections.abc import Sequence
from typing import ClassVar, Literal

from pydantic import Field

from fatigue_planner.ergonomics.hand_strain import HandStrain
from fatigue_planner.ergonomics.operation import Job
from fatigue_planner.ergonomics.result import Assessment, Origin, Phrase
from fatigue_planner.ergonomics.stated import Shift
from fatigue_planner.ergonomics.strain_equation import Effort, Task, composite_index, cumulative_index


class CumulativeStrainIndex(HandStrain):
    """The strain index of a shift with job rotation, for the worse hand here; the other work is as hard for both."""

    title: ClassVar[str] = "cumulative strain index"
    edition: ClassVar[str] = (
        "Garg, Moore & Kapellusch 2017 (CUSI) by abstract and two programs, its equation not read in the paper; the "
        "limit of 10 is recalled"
    )
    origin: ClassVar[Origin] = Origin.RECALLED

    kind: Literal["cumulative_strain_index"] = Field(
        default="cumulative_strain_index", description="Cumulative strain index (Garg, Moore and Kapellusch 2017)."
    )

    def assess(self, job: Job) -> Assessment:
        """See Indicator.assess."""
        if not job.shift.other_work:
            return self.does_not_apply(
                Phrase("no other work is stated (other_work), so the revised strain index is that of the shift")
            )
        if job.shift.hours is None:
            return self.does_not_apply(Phrase("how long this work lasts in the shift is not stated (hours)"))
        return super().assess(job)

    def index(self, efforts: Sequence[Effort], hours: float, shift: Shift) -> float:
        """See HandStrain.index."""
        others = [Task(other.strain_index, other.hours) for other in shift.other_work]
        return cumulative_index([Task(composite_index(efforts, hours), hours), *others])

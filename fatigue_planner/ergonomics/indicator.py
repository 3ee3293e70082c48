"""What every kind of indicator is: a published method that judges a job; thresholds that it leaves open are keys."""

from abc import abstractmethod
from typing import Any, ClassVar

from fatigue_planner.core.plugins import Registry
from fatigue_planner.core.settings import Settings
from fatigue_planner.ergonomics.operation import Job
from fatigue_planner.ergonomics.result import Assessment, Origin, Phrase


class Indicator(Settings):
    """A method; every kind has `kind: Literal["its name"]`, a title and an edition, and says what it finds in a job.

    Thresholds that the publication leaves open are keys with a default. An input that is not stated makes a range, and
    is named (`Assessment.decides`). Where the method may not be used, the answer is `does_not_apply`, with the reason.
    """

    title: ClassVar[str]
    # Method, edition and variant of its tables, as they are printed.
    edition: ClassVar[str]
    # How far its rules were checked, the least checked of them.
    origin: ClassVar[Origin]

    kind: str

    @abstractmethod
    def assess(self, job: Job) -> Assessment:
        """What the method says of the operations of a cycle."""

    def answer(self, **found: Any) -> Assessment:
        """What the method finds, with its name, edition and origin."""
        return Assessment(self.kind, self.title, self.edition, self.origin, **found)

    def does_not_apply(self, reason: Phrase) -> Assessment:
        """The answer where the method may not be used."""
        return self.answer(applies=False, reason=reason)


INDICATORS = Registry("indicator", Indicator)  # type: ignore[type-abstract]

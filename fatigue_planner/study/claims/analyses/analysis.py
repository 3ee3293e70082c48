"""Ways to answer the elementary questions about two policies."""

from abc import ABC, abstractmethod
from typing import ClassVar

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.claims.answers import Answer, RegretJob
from fatigue_planner.study.claims.measurements import Comparison, Measurements


class Analysis(ABC):
    """One way to draw conclusions from runs; docs/claims.md has the rules."""

    title: ClassVar[str]

    def __init__(self, measurements: Measurements, settings: StatisticsSettings) -> None:
        self.measurements = measurements
        self.level = settings.significance_level
        self.margin = settings.equivalence_margin

    @abstractmethod
    def unusable(self, comparison: Comparison) -> str:
        """Why nothing can be concluded from a comparison; empty if something can."""

    @abstractmethod
    def significantly_better(self, comparison: Comparison) -> RegretJob:
        """Whether the first policy is better by more than chance explains."""

    @abstractmethod
    def better(self, comparison: Comparison) -> RegretJob:
        """Whether the first policy's mean return is higher."""

    @abstractmethod
    def not_different(self, comparison: Comparison) -> RegretJob:
        """Whether the two do not differ significantly."""

    @abstractmethod
    def equivalent(self, comparison: Comparison) -> RegretJob:
        """Whether the two perform alike."""

    @abstractmethod
    def same_mean(self, comparison: Comparison) -> RegretJob:
        """Whether the two have the same mean return."""

    @abstractmethod
    def at_least_as_good(self, comparison: Comparison) -> RegretJob:
        """Whether the first policy is as good as the second, or better."""

    @abstractmethod
    def size(self, comparison: Comparison) -> tuple[float, float]:
        """The least and the largest size the difference may have, as a share of the mean cost."""

    def by_sign(self, comparison: Comparison) -> RegretJob:
        """Which is better where no test is made."""
        share = comparison.share(comparison.difference)
        if comparison.difference == 0:
            return RegretJob(Answer.FAILS, "the very same return", 0.0)
        small = ", by less than the margin" if abs(share) < self.margin else ""
        if comparison.difference > 0:
            return RegretJob(Answer.HOLDS, f"better{small}", -share)
        return RegretJob(Answer.FAILS, f"worse{small}", -share)

    def by_margin(self, comparison: Comparison) -> RegretJob:
        """Whether the two are the same within the margin where no test is made."""
        size = abs(comparison.share(comparison.difference))
        if size < self.margin:
            return RegretJob(Answer.HOLDS, f"the same within {100 * self.margin:.3g} % of the cost", size)
        return RegretJob(Answer.FAILS, f"more than {100 * self.margin:.3g} % of the cost apart", size)

    def as_good_by_margin(self, comparison: Comparison) -> RegretJob:
        """Whether the first is at least as good within the margin where no test is made."""
        share = comparison.share(comparison.difference)
        if share > -self.margin:
            return RegretJob(Answer.HOLDS, "better, or worse by less than the margin", -share)
        return RegretJob(Answer.FAILS, "worse by more than the margin", -share)

"""The paper's own analysis (section IV-E, footnote 4)."""

import math

from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import Answer, RegretJob
from fatigue_planner.study.claims.measurements import Comparison


class PaperAnalysis(Analysis):
    """Student's unpaired t-test, not corrected; where a policy's every run is the same, the values as they are."""

    title = "paper's own test"

    def unusable(self, comparison: Comparison) -> str:
        """One run that chance has made, or no p-value where one is needed."""
        if any(one.runs < 2 and not one.deterministic for one in (comparison.first, comparison.second)):
            return "one run only"
        if not _by_value(comparison) and math.isnan(comparison.contrast.student_p):
            return comparison.contrast.note or "no p-value"
        return ""

    def significantly_better(self, comparison: Comparison) -> RegretJob:
        """Student's p < level and a higher mean."""
        if _by_value(comparison):
            return self.by_sign(comparison)
        against = -comparison.share(comparison.difference)
        p_value = _p_value(comparison)
        if comparison.contrast.student_p >= self.level:
            return RegretJob(Answer.FAILS, f"not significantly different ({p_value})", against)
        if comparison.difference > 0:
            return RegretJob(Answer.HOLDS, f"significantly better ({p_value})", against)
        return RegretJob(Answer.FAILS, f"significantly worse ({p_value})", against)

    def better(self, comparison: Comparison) -> RegretJob:
        """The means as they are."""
        return self.by_sign(comparison)

    def not_different(self, comparison: Comparison) -> RegretJob:
        """Student's p >= level."""
        if _by_value(comparison):
            return self.by_margin(comparison)
        size = abs(comparison.share(comparison.difference))
        if comparison.contrast.student_p >= self.level:
            return RegretJob(Answer.HOLDS, f"not significantly different ({_p_value(comparison)})", size)
        return RegretJob(Answer.FAILS, f"significantly different ({_p_value(comparison)})", size)

    def equivalent(self, comparison: Comparison) -> RegretJob:
        """What the paper calls equivalent is what its test does not tell apart."""
        return self.not_different(comparison)

    def same_mean(self, comparison: Comparison) -> RegretJob:
        """The means as they are; the paper gives no yardstick for the same, so it is the margin."""
        return self.by_margin(comparison)

    def at_least_as_good(self, comparison: Comparison) -> RegretJob:
        """Not significantly worse."""
        if _by_value(comparison):
            return self.as_good_by_margin(comparison)
        against = -comparison.share(comparison.difference)
        if comparison.difference < 0 and comparison.contrast.student_p < self.level:
            return RegretJob(Answer.FAILS, f"significantly worse ({_p_value(comparison)})", against)
        return RegretJob(Answer.HOLDS, f"not significantly worse ({_p_value(comparison)})", against)

    def size(self, comparison: Comparison) -> tuple[float, float]:
        """Of the difference of the means as they are."""
        size = abs(comparison.share(comparison.difference))
        return size, size


def _by_value(comparison: Comparison) -> bool:
    return comparison.first.deterministic or comparison.second.deterministic


def _p_value(comparison: Comparison) -> str:
    return f"Student's p = {comparison.contrast.student_p:.2g}"

"""Paired tests, corrected within their family, and equivalence that must be shown."""

import math

from fatigue_planner.experiment.statistics_settings import POWER
from fatigue_planner.study.claims.analyses.analysis import Analysis
from fatigue_planner.study.claims.answers import Answer, RegretJob
from fatigue_planner.study.claims.measurements import Comparison


class ModernAnalysis(Analysis):
    """Paired t-tests with Holm's correction; two one-sided tests against the margin (Schuirmann 1987)."""

    title = "modern analysis"

    def unusable(self, comparison: Comparison) -> str:
        """No p-value although chance has a part."""
        if not comparison.exact and math.isnan(comparison.contrast.holm_p):
            return comparison.contrast.note or "no p-value"
        return ""

    def significantly_better(self, comparison: Comparison) -> RegretJob:
        """Holm's p < level and a positive difference; worse or equivalent fails."""
        if comparison.exact:
            return self.by_sign(comparison)
        contrast = comparison.contrast
        against = -comparison.share(contrast.difference)
        if contrast.holm_p < self.level:
            if contrast.difference < 0:
                return RegretJob(Answer.FAILS, f"significantly worse ({_holm(comparison)})", against)
            small = ", though by less than the margin" if self._within(comparison) else ""
            return RegretJob(Answer.HOLDS, f"significantly better{small} ({_holm(comparison)})", against)
        if self._within(comparison):
            return RegretJob(Answer.FAILS, f"the same within the margin ({_tost(comparison)})", against)
        found = 100 * comparison.share(contrast.detectable_difference)
        return RegretJob(
            Answer.OPEN,
            f"neither better nor the same is shown ({_holm(comparison)}; {found:.2g} % would have been found with "
            f"{100 * POWER:g} % power, uncorrected)",
            against,
        )

    def better(self, comparison: Comparison) -> RegretJob:
        """A better mean that chance may have made is none."""
        return self.significantly_better(comparison)

    def not_different(self, comparison: Comparison) -> RegretJob:
        """Holm's p < level fails; the same within the margin holds."""
        if comparison.exact:
            return self.by_margin(comparison)
        size = abs(comparison.share(comparison.contrast.difference))
        if comparison.contrast.holm_p < self.level:
            small = ", though by less than the margin" if self._within(comparison) else ""
            return RegretJob(Answer.FAILS, f"significantly different{small} ({_holm(comparison)})", size)
        if self._within(comparison):
            return RegretJob(Answer.HOLDS, f"the same within the margin ({_tost(comparison)})", size)
        return RegretJob(Answer.OPEN, f"neither different nor the same is shown ({_holm(comparison)})", size)

    def equivalent(self, comparison: Comparison) -> RegretJob:
        """The same within the margin holds; an interval outside it fails."""
        if comparison.exact:
            return self.by_margin(comparison)
        contrast = comparison.contrast
        size = abs(comparison.share(contrast.difference))
        if self._within(comparison):
            return RegretJob(Answer.HOLDS, f"the same within the margin ({_tost(comparison)})", size)
        if contrast.t_low > contrast.equivalence_margin or contrast.t_high < -contrast.equivalence_margin:
            return RegretJob(Answer.FAILS, "more than the margin apart, with all of the interval", size)
        return RegretJob(Answer.OPEN, f"the same within the margin is not shown ({_tost(comparison)})", size)

    def same_mean(self, comparison: Comparison) -> RegretJob:
        """As `equivalent`: means of samples are never the same."""
        return self.equivalent(comparison)

    def at_least_as_good(self, comparison: Comparison) -> RegretJob:
        """The interval lies above minus the margin (holds) or below it (fails)."""
        if comparison.exact:
            return self.as_good_by_margin(comparison)
        contrast = comparison.contrast
        against = -comparison.share(contrast.difference)
        if contrast.t_low > -contrast.equivalence_margin:
            return RegretJob(Answer.HOLDS, "not worse than the margin, with all of the interval", against)
        if contrast.t_high < -contrast.equivalence_margin:
            return RegretJob(Answer.FAILS, "worse by more than the margin, with all of the interval", against)
        return RegretJob(Answer.OPEN, "the interval has the margin inside", against)

    def size(self, comparison: Comparison) -> tuple[float, float]:
        """What the interval of the difference leaves for its size."""
        ends = [comparison.share(end) for end in (comparison.contrast.t_low, comparison.contrast.t_high)]
        least, largest = sorted(map(abs, ends))
        return (0.0 if ends[0] <= 0 <= ends[1] else least), largest

    def _within(self, comparison: Comparison) -> bool:
        return comparison.contrast.equivalence_p < self.level


def _holm(comparison: Comparison) -> str:
    return f"Holm-adjusted p = {comparison.contrast.holm_p:.2g}"


def _tost(comparison: Comparison) -> str:
    return f"TOST p = {comparison.contrast.equivalence_p:.2g}"

"""The two ways to answer the elementary questions about two policies; docs/claims.md has their rules side by side.

The modern analysis makes paired t-tests with Holm's correction; equivalence must be shown by two one-sided tests
against the margin (TOST, Schuirmann 1987). The paper's own (section IV-E, footnote 4) makes Student's unpaired t-test,
not corrected, and takes values as they are where a policy is the same in every run.
"""

import math
from dataclasses import dataclass

from fatigue_planner.experiment.statistics_settings import POWER
from fatigue_planner.study.claims.measurements import MeasuredPair, Measurements
from fatigue_planner.study.claims.schema import Answer
from fatigue_planner.study.statistics.multiple_testing import Pair

# An answer, its reason in words, and how much the difference speaks against the statement, as a fraction of the cost
# (negative: for it): of several comparisons that fail the one with the largest number is the strongest.
Reply = tuple[Answer, str, float]


@dataclass(frozen=True)
class Analysis:
    """One way to draw conclusions from a measured pair of policies.

    level: of significance; margin: differences below this fraction of the cost count as equal; modern: else the
    paper's own analysis.
    """

    measurements: Measurements
    level: float
    margin: float
    modern: bool

    def usable(self, names: Pair) -> MeasuredPair | str:
        """What was measured of a pair, or why nothing can be concluded from it."""
        pair = self.measurements.measured(names)
        if isinstance(pair, str):
            return pair
        if not self.modern and any(
            sample.runs < 2 and not sample.deterministic for sample in (pair.first, pair.second)
        ):
            return "one run only"
        if not self._untested(pair) and math.isnan(self._p_value(pair)):
            return pair.contrast.note or "no p-value"
        return pair

    def significantly_better(self, pair: MeasuredPair) -> Reply:
        """Whether the first policy is better by more than chance explains."""
        if self._untested(pair):
            return self._by_sign(pair)
        difference = self._difference(pair)
        against = -pair.fraction(difference)
        if self._p_value(pair) < self.level:
            if difference < 0:
                return Answer.FAILS, f"significantly worse ({self._test(pair)})", against
            return Answer.HOLDS, f"significantly better{self._small(pair)} ({self._test(pair)})", against
        if not self.modern:
            return Answer.FAILS, f"not significantly different ({self._test(pair)})", against
        if self._within(pair):
            return Answer.FAILS, f"the same within the margin ({_tost(pair)})", against
        found = 100 * pair.fraction(pair.contrast.detectable_difference)
        reason = (
            f"neither better nor the same is shown ({self._test(pair)}; {found:.2g} % would have been found with "
            f"{100 * POWER:g} % power, uncorrected)"
        )
        return Answer.OPEN, reason, against

    def better(self, pair: MeasuredPair) -> Reply:
        """Whether the first policy's mean return is higher; modern: a better mean that chance may have made is none."""
        return self.significantly_better(pair) if self.modern else self._by_sign(pair)

    def not_different(self, pair: MeasuredPair) -> Reply:
        """Whether the two do not differ significantly; modern: only if they are shown to be the same."""
        if self._untested(pair):
            return self._by_margin(pair)
        size = abs(pair.fraction(self._difference(pair)))
        if self._p_value(pair) < self.level:
            return Answer.FAILS, f"significantly different{self._small(pair)} ({self._test(pair)})", size
        if not self.modern:
            return Answer.HOLDS, f"not significantly different ({self._test(pair)})", size
        if self._within(pair):
            return Answer.HOLDS, f"the same within the margin ({_tost(pair)})", size
        return Answer.OPEN, f"neither different nor the same is shown ({self._test(pair)})", size

    def equivalent(self, pair: MeasuredPair) -> Reply:
        """Whether the two perform alike; to the paper, what its test does not tell apart is equivalent."""
        if not self.modern:
            return self.not_different(pair)
        if self._untested(pair):
            return self._by_margin(pair)
        contrast, size = pair.contrast, abs(pair.fraction(self._difference(pair)))
        if self._within(pair):
            return Answer.HOLDS, f"the same within the margin ({_tost(pair)})", size
        if contrast.t_low > contrast.equivalence_margin or contrast.t_high < -contrast.equivalence_margin:
            return Answer.FAILS, "more than the margin apart, with all of the interval", size
        return Answer.OPEN, f"the same within the margin is not shown ({_tost(pair)})", size

    def same_mean(self, pair: MeasuredPair) -> Reply:
        """Whether the two have the same mean return: means of samples never have, so the margin is the yardstick."""
        return self.equivalent(pair) if self.modern else self._by_margin(pair)

    def at_least_as_good(self, pair: MeasuredPair) -> Reply:
        """Whether the first policy is as good as the second, or better."""
        difference = self._difference(pair)
        against = -pair.fraction(difference)
        if self._untested(pair):
            if against < self.margin:
                return Answer.HOLDS, "better, or worse by less than the margin", against
            return Answer.FAILS, "worse by more than the margin", against
        if not self.modern:
            if difference < 0 and self._p_value(pair) < self.level:
                return Answer.FAILS, f"significantly worse ({self._test(pair)})", against
            return Answer.HOLDS, f"not significantly worse ({self._test(pair)})", against
        contrast = pair.contrast
        if contrast.t_low > -contrast.equivalence_margin:
            return Answer.HOLDS, "not worse than the margin, with all of the interval", against
        if contrast.t_high < -contrast.equivalence_margin:
            return Answer.FAILS, "worse by more than the margin, with all of the interval", against
        return Answer.OPEN, "the interval has the margin inside", against

    def size(self, pair: MeasuredPair) -> tuple[float, float]:
        """The least and the largest size the difference may have, as a fraction of the mean cost."""
        if not self.modern:
            size = abs(pair.fraction(self._difference(pair)))
            return size, size
        ends = [pair.fraction(end) for end in (pair.contrast.t_low, pair.contrast.t_high)]
        least, largest = sorted(map(abs, ends))
        return (0.0 if ends[0] <= 0 <= ends[1] else least), largest

    def _untested(self, pair: MeasuredPair) -> bool:
        """Whether the values are taken as they are, without a test."""
        if self.modern:
            return pair.exact
        without_spread = pair.exact and math.isnan(pair.contrast.student_p)
        return pair.first.deterministic or pair.second.deterministic or without_spread

    def _difference(self, pair: MeasuredPair) -> float:
        """First minus second: the mean of the differences where runs are paired, else the difference of the means."""
        return pair.contrast.difference if self.modern and not self._untested(pair) else pair.difference

    def _p_value(self, pair: MeasuredPair) -> float:
        return pair.contrast.holm_p if self.modern else pair.contrast.student_p

    def _test(self, pair: MeasuredPair) -> str:
        name = "Holm-adjusted" if self.modern else "Student's"
        return f"{name} p = {self._p_value(pair):.2g}"

    def _within(self, pair: MeasuredPair) -> bool:
        return self.modern and pair.contrast.equivalence_p < self.level

    def _small(self, pair: MeasuredPair) -> str:
        return ", though by less than the margin" if self._within(pair) else ""

    def _by_sign(self, pair: MeasuredPair) -> Reply:
        """Which is better where no test is made."""
        fraction = pair.fraction(pair.difference)
        if pair.difference == 0:
            return Answer.FAILS, "the very same return", 0.0
        small = ", by less than the margin" if abs(fraction) < self.margin else ""
        if pair.difference > 0:
            return Answer.HOLDS, f"better{small}", -fraction
        return Answer.FAILS, f"worse{small}", -fraction

    def _by_margin(self, pair: MeasuredPair) -> Reply:
        """Whether the two are the same within the margin where no test is made."""
        size = abs(pair.fraction(pair.difference))
        if size < self.margin:
            return Answer.HOLDS, f"the same within {100 * self.margin:.3g} % of the cost", size
        return Answer.FAILS, f"more than {100 * self.margin:.3g} % of the cost apart", size


def _tost(pair: MeasuredPair) -> str:
    return f"TOST p = {pair.contrast.equivalence_p:.2g}"

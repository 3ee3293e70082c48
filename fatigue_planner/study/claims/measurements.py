"""What was measured of two policies in the same cell, and how much any policy could win over one of them."""

import math
from dataclasses import dataclass

import pandas as pd

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.statistics.contrast import Contrast, contrasts_in
from fatigue_planner.study.statistics.multiple_testing import Pair

CERTAIN = 2  # standard errors that the largest win must stay below the needed one to say so


@dataclass(frozen=True)
class Sample:
    """The runs of a policy: mean and standard deviation (n - 1) of the discounted return, how many runs.

    deterministic: every run is the same, so that a single run is enough.
    """

    mean: float
    standard_deviation: float
    runs: int
    deterministic: bool


@dataclass(frozen=True)
class MeasuredPair:
    """A pair of policies and what was measured of it; differences are first minus second, in discounted return."""

    pair: Pair
    first: Sample
    second: Sample
    contrast: Contrast

    @property
    def difference(self) -> float:
        """Of the means, rounding aside; positive: the first is better."""
        return self.contrast.difference if self.exact else self.first.mean - self.second.mean

    @property
    def exact(self) -> bool:
        """Whether chance has no part in the difference."""
        return self.contrast.standard_error == 0

    def fraction(self, value: float) -> float:
        """A difference as a fraction of the mean cost of the two; NaN if that is 0."""
        cost = -(self.first.mean + self.second.mean) / 2
        return value / cost if cost else math.nan

    def numbers(self) -> str:
        """The difference in words, in % of the mean cost, with its interval where chance has a part in it."""
        contrast = self.contrast
        interval = ""
        if not self.exact and not math.isnan(contrast.t_low):
            interval = f" [{100 * self.fraction(contrast.t_low):+.2f}, {100 * self.fraction(contrast.t_high):+.2f}]"
        return f"{self.pair.first} - {self.pair.second} {100 * self.fraction(self.difference):+.2f} %{interval}"


class Measurements:
    """Tables of trials and contrasts, looked up by pair.

    trials: columns condition, n_cycles, policy, trial, deterministic, discounted_return; contrasts: of these trials,
    by `statistics.contrasts.contrasts`.
    """

    def __init__(self, trials: pd.DataFrame, contrasts: pd.DataFrame) -> None:
        groups = trials.sort_values("trial", kind="stable").groupby(["condition", "n_cycles", "policy"])
        table = groups["discounted_return"].agg(["mean", "std", "size"])
        table["same"] = groups["deterministic"].all()
        self._samples = {
            key: Sample(float(mean), float(deviation), int(size), bool(same))
            for key, mean, deviation, size, same in table.itertuples(name=None)
        }
        # reversed: as in `contrast_of`, a pair of several families is taken from the first one
        self._contrasts = {
            Pair(contrast.condition, contrast.n_cycles, contrast.first, contrast.second): contrast
            for contrast in reversed(contrasts_in(contrasts))
        }

    def sample(self, condition: str, n_cycles: int, policy: str) -> Sample | None:
        """The runs of a policy, if there are any."""
        return self._samples.get((condition, n_cycles, policy))

    def measured(self, pair: Pair) -> MeasuredPair | str:
        """What was measured of a pair, in its order, or the reason why there is nothing."""
        first, second = (self.sample(*pair.cell, policy) for policy in (pair.first, pair.second))
        if first is None or second is None:
            return f"{pair.first if first is None else pair.second} was not run"
        contrast = self._contrasts.get(pair)
        if contrast is None:
            opposite = self._contrasts.get(Pair(*pair.cell, pair.second, pair.first))
            if opposite is None:
                return "the two are in no family of the experiment's statistics"
            contrast = opposite.flipped()
        return MeasuredPair(pair, first, second, contrast)


@dataclass(frozen=True)
class Headroom:
    """How much there is to win over a policy, as fractions of its mean cost.

    largest: its mean cost minus the bound, and the standard error of that
    small: whether the largest is less than the margin within which policies count as equal
    needed: the smallest difference that the paper's test (Student's, unpaired) would call significant, with the
        spreads the two policies have; NaN where the paper makes no test
    """

    largest: float
    standard_error: float
    small: bool
    needed: float

    def in_words(self, policy: str) -> str:
        """The headroom over the policy of this name as text."""
        spread = f" ± {100 * self.standard_error:.2f}" if self.standard_error > 0 else ""
        small = ", less than the margin" if self.small else ""
        text = f"no policy could win by more than {100 * self.largest:.2f}{spread} % of {policy}'s cost{small}"
        if math.isnan(self.needed):
            return text
        too_little = self.largest + CERTAIN * self.standard_error < self.needed
        close = ", so that not even the best possible could be expected to win significantly" if too_little else ""
        return f"{text}; the paper's test needs {100 * self.needed:.2f} %{close}"


class Headrooms:
    """The headroom over any policy of a benchmark.

    bounds: columns condition, n_cycles, cost_bound (`benchmark.bounds`).
    """

    def __init__(self, bounds: pd.DataFrame, measurements: Measurements, settings: StatisticsSettings) -> None:
        table = bounds.drop_duplicates(["condition", "n_cycles"]).set_index(["condition", "n_cycles"])
        self._bounds = table["cost_bound"].to_dict()
        self._measurements = measurements
        self._settings = settings

    def over_second(self, pair: Pair) -> Headroom | None:
        """What could be won over a pair's second policy; None where there is no bound or no run."""
        bound = self._bounds.get(pair.cell)
        first, second = (self._measurements.sample(*pair.cell, policy) for policy in (pair.first, pair.second))
        if bound is None or first is None or second is None or not second.mean < 0:
            return None
        cost = -second.mean
        error = 0.0 if second.deterministic else second.standard_deviation / math.sqrt(second.runs)
        largest = (cost - bound) / cost
        small = largest < self._settings.equivalence_margin
        return Headroom(largest, error / cost, small, self._needed(first, second) / cost)

    def _needed(self, first: Sample, second: Sample) -> float:
        if first.deterministic or second.deterministic or min(first.runs, second.runs) < 2:
            return math.nan
        from scipy.stats import t  # noqa: PLC0415 - takes half a second

        freedom = first.runs + second.runs - 2
        squares = sum((sample.runs - 1) * sample.standard_deviation**2 for sample in (first, second))
        error = math.sqrt(squares / freedom * (1 / first.runs + 1 / second.runs))
        return float(t.ppf(1 - self._settings.significance_level / 2, freedom)) * error

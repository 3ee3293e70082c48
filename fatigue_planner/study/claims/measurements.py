"""What was measured of two policies in the same cell: both samples and their contrast."""

import math
from dataclasses import dataclass

import pandas as pd

from fatigue_planner.study.statistics.contrast import Contrast, contrasts_in
from fatigue_planner.study.statistics.multiple_testing import Pair


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

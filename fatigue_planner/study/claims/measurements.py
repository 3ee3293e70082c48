"""What was measured of two policies under the same condition: both samples and their contrast."""

import math
from dataclasses import dataclass

import pandas as pd

from fatigue_planner.study.statistics.contrast import Contrast, contrasts_in


@dataclass(frozen=True)
class Pair:
    """Two policies in a condition and a number of cycles."""

    condition: str
    n_cycles: int
    first: str
    second: str


@dataclass(frozen=True)
class Sample:
    """The runs of a policy: mean and standard deviation (n - 1) of the discounted return, how many runs.

    deterministic: every run is the same, so that one is enough.
    """

    mean: float
    standard_deviation: float
    runs: int
    deterministic: bool


@dataclass(frozen=True)
class Comparison:
    """Two policies compared; differences are first minus second, in discounted return."""

    pair: Pair
    first: Sample
    second: Sample
    contrast: Contrast

    @property
    def difference(self) -> float:
        """Of the means; positive: the first is better."""
        return self.first.mean - self.second.mean

    @property
    def exact(self) -> bool:
        """Whether chance has no part in the difference."""
        return self.contrast.standard_error == 0

    def share(self, value: float) -> float:
        """A difference as a share of the mean cost of the two; NaN if that is 0."""
        cost = -(self.first.mean + self.second.mean) / 2
        return value / cost if cost else math.nan

    def numbers(self) -> str:
        """The difference in words, in % of the mean cost, with its interval where chance has a part in it."""
        contrast = self.contrast
        interval = ""
        if not self.exact and not math.isnan(contrast.t_low):
            interval = f" [{100 * self.share(contrast.t_low):+.2f}, {100 * self.share(contrast.t_high):+.2f}]"
        return f"{self.pair.first} - {self.pair.second} {100 * self.share(self.difference):+.2f} %{interval}"


class Measurements:
    """Tables of trials and contrasts, looked up by pair.

    trials: columns condition, n_cycles, policy, deterministic, discounted_return; contrasts: of
    `statistics.contrasts.contrasts`.
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
            (one.condition, one.n_cycles, one.first, one.second): one for one in reversed(contrasts_in(contrasts))
        }
        self._found: dict[Pair, Comparison | str] = {}

    def compare(self, pair: Pair) -> Comparison | str:
        """The comparison, in the pair's order, or the reason why there is none."""
        if pair not in self._found:
            self._found[pair] = self._compare(pair)
        return self._found[pair]

    def sample(self, condition: str, n_cycles: int, policy: str) -> Sample | None:
        """The runs of a policy, if there are any."""
        return self._samples.get((condition, n_cycles, policy))

    def _compare(self, pair: Pair) -> Comparison | str:
        place = (pair.condition, pair.n_cycles)
        first, second = (self.sample(*place, policy) for policy in (pair.first, pair.second))
        if first is None or second is None:
            return f"{pair.first if first is None else pair.second} was not run"
        contrast = self._contrasts.get((*place, pair.first, pair.second))
        if contrast is None:
            opposite = self._contrasts.get((*place, pair.second, pair.first))
            if opposite is None:
                return "the two are in no family of the experiment's statistics"
            contrast = opposite.flipped()
        return Comparison(pair, first, second, contrast)

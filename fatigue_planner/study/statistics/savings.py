"""What one policy saves of another one's cost, run by run in the same world."""

from dataclasses import dataclass, replace
from math import nan

import pandas as pd

from fatigue_planner.core.text import percent, percent_range
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.statistics.contrasts import compute_contrast
from fatigue_planner.study.statistics.multiple_testing import Pair
from fatigue_planner.study.statistics.pairing import pair_runs, runs_by_policy


@dataclass(frozen=True)
class Saving:
    """Fractions of the mean cost of `over` that `policy` saves; negative where it costs more.

    low, high: paired t interval; the share itself where nothing is left to chance, NaN where it is not known.
    """

    condition: str
    n_cycles: int
    policy: str
    over: str
    share: float
    low: float = nan
    high: float = nan

    def turned(self) -> "Saving":
        """The same as what `policy` costs more."""
        return replace(self, share=-self.share, low=-self.high, high=-self.low)

    def compared(self, what: str) -> str:
        """`2 % less than` something or, where `policy` costs more, `2 % more than`."""
        if self.share < 0:
            return f"{self.turned().text()} more than {what}"
        return f"{self.text()} less than {what}" if self.share > 0 or self.low < self.high else f"as much as {what}"

    def text(self) -> str:
        """The share, with its interval if it has one."""
        interval = f" ({percent_range(self.low, self.high)})" if self.low < self.high else ""
        return f"{percent(self.share)}{interval}"


def savings(trials: pd.DataFrame, pairs: list[Pair], settings: StatisticsSettings, seed: int) -> list[Saving]:
    """What the first of every pair saves of the second's cost.

    `trials` has the columns condition, n_cycles, policy, trial, deterministic and discounted_return. NaN where runs
    are missing or the cost is not positive.
    """
    runs = runs_by_policy(trials)
    found = []
    for pair in pairs:
        returns = pair_runs(runs[*pair.cell, pair.first], runs[*pair.cell, pair.second])
        contrast = compute_contrast("", pair, returns, settings, seed)
        cost = -contrast.second_mean
        shares = [end / cost if cost > 0 else nan for end in (contrast.difference, contrast.t_low, contrast.t_high)]
        found.append(Saving(pair.condition, pair.n_cycles, pair.first, pair.second, *shares))
    return found

"""How much any policy could win over another one, from a cost that no policy can beat."""

import math
from dataclasses import dataclass

import pandas as pd

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.claims.measurements import Measurements, Pair, Sample

SURE = 2  # standard errors that the largest win must stay below the needed one to say so


@dataclass(frozen=True)
class Room:
    """What there is to win over a policy, as shares of its mean cost.

    largest: its mean cost minus the bound, and the standard error of that
    small: whether the largest is less than the margin within which policies count as equal
    needed: the smallest difference that the paper's test (Student's, unpaired) would call significant, with the
        spreads the two policies have; NaN where the paper makes no test
    """

    largest: float
    standard_error: float
    small: bool
    needed: float

    def told(self, policy: str) -> str:
        """In words."""
        spread = f" ± {100 * self.standard_error:.2f}" if self.standard_error > 0 else ""
        small = ", less than the margin" if self.small else ""
        text = f"no policy could win by more than {100 * self.largest:.2f}{spread} % of {policy}'s cost{small}"
        if math.isnan(self.needed):
            return text
        surely = self.largest + SURE * self.standard_error < self.needed
        close = ", so that not even the best possible could be expected to win significantly" if surely else ""
        return f"{text}; the paper's test needs {100 * self.needed:.2f} %{close}"


class Rooms:
    """Room to win over any policy of a benchmark.

    bounds: columns condition, n_cycles, cost_bound (`benchmark.bounds`).
    """

    def __init__(self, bounds: pd.DataFrame, measurements: Measurements, settings: StatisticsSettings) -> None:
        table = bounds.drop_duplicates(["condition", "n_cycles"]).set_index(["condition", "n_cycles"])
        self._bounds = table["cost_bound"].to_dict()
        self._measurements = measurements
        self._settings = settings

    def over_second(self, pair: Pair) -> Room | None:
        """What could be won over a pair's second policy; None where there is no bound or no run."""
        place = (pair.condition, pair.n_cycles)
        bound = self._bounds.get(place)
        first, second = (self._measurements.sample(*place, policy) for policy in (pair.first, pair.second))
        if bound is None or first is None or second is None or not second.mean < 0:
            return None
        cost = -second.mean
        error = 0.0 if second.deterministic else second.standard_deviation / math.sqrt(second.runs)
        largest = (cost - bound) / cost
        small = largest < self._settings.equivalence_margin
        return Room(largest, error / cost, small, self._needed(first, second) / cost)

    def _needed(self, first: Sample, second: Sample) -> float:
        if first.deterministic or second.deterministic or min(first.runs, second.runs) < 2:
            return math.nan
        from scipy.stats import t  # noqa: PLC0415 - takes half a second

        freedom = first.runs + second.runs - 2
        squares = sum((one.runs - 1) * one.standard_deviation**2 for one in (first, second))
        error = math.sqrt(squares / freedom * (1 / first.runs + 1 / second.runs))
        return float(t.ppf(1 - self._settings.significance_level / 2, freedom)) * error

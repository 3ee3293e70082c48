"""The table of contrasts: every comparison of every family, with intervals, tests, effects and corrections."""

from dataclasses import asdict

import pandas as pd

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.statistics.contrast import COLUMNS
from fatigue_planner.study.statistics.corrections import holm
from fatigue_planner.study.statistics.families import comparisons
from fatigue_planner.study.statistics.pairing import pair, runs_by_policy

CONTRASTS_FILE = "contrasts.csv"


def contrasts(trials: pd.DataFrame, settings: StatisticsSettings, seed: int) -> pd.DataFrame:
    """One row per comparison of every family, the columns those of `Contrast`.

    `trials` has the columns condition, n_cycles, policy, trial, deterministic and discounted_return. Runs are paired by
    the number of their trial. holm_p corrects paired_p within the family; rows without one do not count.
    A row's other numbers depend on the runs of its two policies, the settings and the seed only.
    """
    from fatigue_planner.study.statistics.measure import measure  # noqa: PLC0415 - loads scipy.stats

    runs = runs_by_policy(trials)
    rows = []
    for comparison in comparisons(trials, settings.families):
        cell = comparison.condition, comparison.n_cycles
        pairs = pair(runs[*cell, comparison.first], runs[*cell, comparison.second])
        rows.append(asdict(measure(comparison, pairs, settings, seed)))
    table = pd.DataFrame(rows, columns=COLUMNS)
    for _, family in table.groupby("family", sort=False):
        table.loc[family.index, "holm_p"] = holm(family["paired_p"].to_numpy(dtype=float))
    return table

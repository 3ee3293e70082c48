"""The tables that compare the policies of a benchmark, made and written.

Apart from `results`, which reads them: what makes them takes two CPU seconds to import.
"""

from pathlib import Path

import pandas as pd

from fatigue_planner.core.files import publish_csv
from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.benchmark.results import COMPARISON_FILE, CONTRASTS_FILE
from fatigue_planner.study.statistics.comparison import comparison_table
from fatigue_planner.study.statistics.contrasts import contrasts


def publish_comparisons(
    folder: Path, trials: pd.DataFrame, settings: StatisticsSettings, seed: int
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Compare the policies; write comparison.csv and contrasts.csv, which are returned."""
    shown = trials[trials["policy"].isin(settings.shown(trials["policy"]))]
    comparison = comparison_table(shown, settings.significance_level)
    publish_csv(folder / COMPARISON_FILE, comparison)
    contrasted = contrasts(trials, settings, seed)
    publish_csv(folder / CONTRASTS_FILE, contrasted)
    return comparison, contrasted

"""Two tables of trials side by side: every policy of one against itself in the other."""

import pandas as pd

from fatigue_planner.experiment.statistics_settings import StatisticsSettings
from fatigue_planner.study.statistics.contrasts import contrasts

CELL = ["condition", "n_cycles", "policy"]
FIRST, SECOND = "first", "second"


def side_by_side(first: pd.DataFrame, second: pd.DataFrame, settings: StatisticsSettings, seed: int) -> pd.DataFrame:
    """One row per condition, length and policy that both tables have; the columns of `contrasts` and `policy`.

    Runs are paired by trial, up to as many as both have: with the same seed they are in the same worlds; with
    another one the pairs are arbitrary, which is valid, but finds less.
    """
    rows = []
    for label, own, other in ((FIRST, first, second), (SECOND, second, first)):
        shared = own[CELL].drop_duplicates().merge(other[CELL].drop_duplicates())
        most = other.groupby(CELL)["trial"].transform("size")
        sizes = other.assign(most=most).drop_duplicates(CELL)[[*CELL, "most", "deterministic"]]
        both = own.merge(shared).merge(sizes, on=CELL, suffixes=("", "_there"))
        rows.append(both[(both["trial"] < both["most"]) | both["deterministic_there"]].assign(table=label))
    runs = pd.concat(rows, ignore_index=True)
    runs["condition"] = runs["condition"] + "/" + runs["policy"]
    table = contrasts(runs.assign(policy=runs["table"]), settings.model_copy(update={"families": {}}), seed)
    cells = table["condition"].str.rsplit("/", n=1, expand=True) if len(table) else pd.DataFrame(columns=[0, 1])
    return table.assign(condition=cells[0], policy=cells[1])

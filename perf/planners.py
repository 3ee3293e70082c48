"""The tables of docs/planners.md, in Markdown: runs what is not in the results yet, then prints them.

    python perf/planners.py [OPTIONS OF fatplan benchmark]

That is `fatplan benchmark planners --regret --bound`, some ten minutes on two quiet cores; the same command goes on
where it was interrupted. Times are medians over the runs of the mean wall-clock time of a decision.
"""

import json
import subprocess
import sys
from pathlib import Path

import pandas as pd

from fatigue_planner.study.benchmark.bounds import BOUNDS_FILE
from fatigue_planner.study.benchmark.tables import KEY, REGRET_FILE, TIMES_FILE, TRIALS_FILE
from fatigue_planner.study.statistics.regret import regret_table

COMMAND = [sys.executable, "-m", "fatigue_planner", "benchmark", "planners", "--regret", "--bound", "--json"]
# A decision that takes less is not worth a number.
SHORT_MS = 0.01


def losses(folder: Path) -> pd.DataFrame:
    """By policy, the regret in % of the cost in every condition, and milliseconds per decision."""
    trials = pd.read_csv(folder / TRIALS_FILE)
    regrets = regret_table(trials.merge(pd.read_csv(folder / REGRET_FILE), on=KEY))
    times = pd.read_csv(folder / TIMES_FILE).groupby(["policy", "condition"])["mean_planning_time_s"].median()
    shares = regrets.pivot(index="policy", columns="condition", values="run_loss_share")[
        list(trials["condition"].unique())
    ]
    shown = shares.map(lambda share: f"{100 * share:.2g}")
    for condition in shares.columns:
        if condition.startswith("single"):
            milliseconds = 1e3 * times.xs(condition, level="condition")
            shown[f"ms {condition}"] = milliseconds.map(lambda ms: f"< {SHORT_MS}" if ms < SHORT_MS else f"{ms:.2g}")
    return shown.loc[shares.mean(axis=1).sort_values(kind="stable").index]


def gaps(folder: Path) -> pd.DataFrame:
    """By condition, the bound and the best policy's distance from it in %."""
    table = pd.read_csv(folder / BOUNDS_FILE).sort_values("gap", kind="stable").drop_duplicates("condition")
    shown = table.set_index("condition")[["n_cycles", "cost_bound", "exact", "policy"]]
    shown["cost_bound"] = shown["cost_bound"].map("{:.6f}".format)
    error = table.set_index("condition")["standard_error"].fillna(0.0)
    shown["gap"] = [f"{100 * gap:.2f} ± {100 * one:.2f} %" for gap, one in zip(table["gap"], error, strict=True)]
    return shown


def markdown(table: pd.DataFrame) -> str:
    """A table of texts."""
    rows = [[str(table.index.name), *map(str, table.columns)], ["---"] * (len(table.columns) + 1)]
    rows += [[f"`{name}`", *map(str, values)] for name, *values in table.itertuples()]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


if __name__ == "__main__":
    done = subprocess.run([*COMMAND, *sys.argv[1:]], check=True, stdout=subprocess.PIPE, text=True)
    folder = Path(json.loads(done.stdout)["folder"])
    print(markdown(losses(folder)), markdown(gaps(folder)), sep="\n\n")

"""How far policies are from the cost that no policy can beat."""

import math
from collections.abc import Sequence

import pandas as pd

from fatigue_planner.study.statistics.rows import cells_of


def gap_table(comparison: pd.DataFrame, bounds: pd.DataFrame) -> pd.DataFrame:
    """One row per condition, length and policy: the mean cost above the bound, as a share of the bound.

    `comparison` is `comparison_table`'s; `bounds` has the columns condition, n_cycles, cost_bound and exact.
    The bound holds for expected costs, so a sample's mean may lie below it by chance: standard_error, also as a
    share; NaN for one run that chance has made. Where the bound is 0 the gap is the cost itself.
    """
    table = comparison.merge(bounds, on=["condition", "n_cycles"])
    cost = -table["mean"]
    table["gap"] = (cost / table["cost_bound"] - 1).where(table["cost_bound"] > 0, cost)
    error = table["standard_deviation"] / table["trials"].map(math.sqrt) / table["cost_bound"]
    table["standard_error"] = error.where(table["trials"] > 1).mask(table["deterministic"], 0.0)
    columns = ["condition", "n_cycles", "cost_bound", "exact", "policy", "gap", "standard_error", "trials"]
    return table[columns]


def gap_text(table: pd.DataFrame, left_out: Sequence[str]) -> str:
    """The table in words: of every cell the bound and the best policy; `left_out`: conditions without a bound."""
    lines = ["Distance to the optimum: no policy's expected cost is below the bound (± is the standard error)."]
    for condition, n_cycles, cell in cells_of(table):
        best = cell.iloc[0]
        bound = f"{'is' if best['exact'] else 'is at least'} {best['cost_bound']:.6f}"
        spread = f" ± {100 * best['standard_error']:.2f} %" if best["standard_error"] > 0 else ""
        one = ", one run" if math.isnan(best["standard_error"]) else ""
        side = "below" if best["gap"] < 0 else "above"
        lines.append(
            f"  {condition}, {n_cycles} cycles: the least expected cost {bound}; the mean of {best['policy']} is "
            f"{100 * abs(best['gap']):.2f} %{spread} {side} {'it' if best['exact'] else 'that'}{one}"
        )
    if left_out:
        lines.append(f"  No bound where the worker is hidden: {', '.join(left_out)}.")
    return "\n".join(lines) + "\n"

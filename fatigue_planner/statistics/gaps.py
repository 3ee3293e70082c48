"""How far policies are from the cost that no policy can beat."""

import math

import pandas as pd


def gap_table(comparison: pd.DataFrame, bounds: pd.DataFrame) -> pd.DataFrame:
    """One row per condition, length and policy: the mean cost above the bound, as a share of the bound.

    `comparison` is `comparison_table`'s; `bounds` has the columns condition, n_cycles, cost_bound and exact.
    The bound holds for expected costs, so a sample's mean may lie below it by chance: standard_error.
    """
    table = comparison.merge(bounds, on=["condition", "n_cycles"])
    cost = -table["mean"]
    table["gap"] = cost / table["cost_bound"] - 1
    error = table["standard_deviation"] / table["trials"].map(math.sqrt)
    table["standard_error"] = error.where(~table["deterministic"], 0.0) / table["cost_bound"]
    columns = ["condition", "n_cycles", "cost_bound", "exact", "policy", "gap", "standard_error", "trials"]
    return table[columns]


def gap_text(table: pd.DataFrame) -> str:
    """The table in words: of every cell the bound and the best policy."""
    lines = ["Distance to the optimum: no policy's expected cost is below the bound."]
    for (condition, n_cycles), cell in table.groupby(["condition", "n_cycles"], sort=False):
        best = cell.iloc[0]
        bound = f"{'is' if best['exact'] else 'is at least'} {best['cost_bound']:.6f}"
        spread = f" ± {100 * best['standard_error']:.2f} %" if best["standard_error"] > 0 else ""
        above = f"{'' if best['exact'] else 'at most '}{100 * best['gap']:.2f} %{spread} above the optimum"
        lines.append(f"  {condition}, {n_cycles} cycles: the least expected cost {bound}; {best['policy']} is {above}")
    return "\n".join(lines) + "\n"

"""What policies lose against the exact reference, and how far they are from the cost that no policy can beat."""

import math
from collections.abc import Sequence

import pandas as pd

from fatigue_planner.study.statistics.pairing import cells_of

GROUP = ["condition", "n_cycles", "policy"]


def regret_table(trials: pd.DataFrame) -> pd.DataFrame:
    """One row per condition, length and policy, the smallest loss per run first within a length.

    `trials` has the columns condition, n_cycles, policy, deterministic, discounted_return, decision_loss, run_loss
    and agreement. Columns made: trials; decision_loss and run_loss (means), run_loss_standard_error, NaN for a single
    run in which chance has a part;
    decision_loss_share and run_loss_share: these as fractions of the mean cost of a run; agreement.
    """
    groups = trials.groupby(GROUP, sort=False)
    table = groups[["decision_loss", "run_loss", "agreement"]].mean()
    cost = -groups["discounted_return"].mean()
    table["trials"] = groups.size()
    error = groups["run_loss"].std(ddof=1) / groups.size() ** 0.5
    table["run_loss_standard_error"] = error.mask(groups["deterministic"].all(), 0.0)
    for name in ("decision_loss", "run_loss"):
        table[f"{name}_share"] = (table[name] / cost).where(cost > 0, 0.0)
    order = trials.drop_duplicates(GROUP[:2]).reset_index()[GROUP[:2]].reset_index(names="order")
    ranked = table.reset_index().merge(order, on=GROUP[:2]).sort_values(["order", "run_loss"], kind="stable")
    return ranked.drop(columns="order").reset_index(drop=True)


def regret_text(table: pd.DataFrame, references: dict[str, str]) -> str:
    """The table in words; `references`: how each condition's reference is called."""
    lines = [
        "Regret: what a policy's decisions lose against the reference's values in the states it visits, per run",
        "(mean ± standard error, and as a fraction of the run's cost), per decision, and how often nothing is lost.",
        "The reference, like the policies, plans for a task without end.",
    ]
    for condition, n_cycles, cell in cells_of(table):
        lines += ["", f"{condition}, {n_cycles} cycles; reference: {references[condition]}"]
        for row in cell.to_dict("records"):
            error = f" ± {row['run_loss_standard_error']:.1g}" if row["run_loss_standard_error"] > 0 else ""
            lines.append(
                f"  {row['policy']:<18} {row['run_loss']:.3g}{error} per run ({row['run_loss_share']:.3%}), "
                f"{row['decision_loss']:.2g} per decision, agrees in {row['agreement']:.1%}"
            )
    return "\n".join(lines) + "\n"


def gap_table(comparison: pd.DataFrame, bounds: pd.DataFrame) -> pd.DataFrame:
    """One row per condition, length and policy: the mean cost above the bound, as a fraction of the bound.

    `comparison` is `comparison_table`'s; `bounds` has the columns condition, n_cycles, cost_bound and exact.
    The bound holds for expected costs, so a sample's mean may lie below it by chance: standard_error, also as
    a fraction; NaN for a single run in which chance has a part. Where the bound is 0 the gap is the cost itself.
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
        single = ", one run" if math.isnan(best["standard_error"]) else ""
        side = "below" if best["gap"] < 0 else "above"
        lines.append(
            f"  {condition}, {n_cycles} cycles: the least expected cost {bound}; the mean of {best['policy']} is "
            f"{100 * abs(best['gap']):.2f} %{spread} {side} {'it' if best['exact'] else 'that'}{single}"
        )
    if left_out:
        lines.append(f"  No bound where the worker is hidden: {', '.join(left_out)}.")
    return "\n".join(lines) + "\n"

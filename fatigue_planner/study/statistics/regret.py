"""What policies lose against the exact reference, summarised."""

import pandas as pd

from fatigue_planner.study.statistics.rows import cells_of

GROUP = ["condition", "n_cycles", "policy"]


def regret_table(trials: pd.DataFrame) -> pd.DataFrame:
    """One row per condition, length and policy, the smallest loss per run first within a length.

    `trials` has the columns condition, n_cycles, policy, deterministic, discounted_return, decision_loss, run_loss
    and agreement. Columns made: trials; decision_loss and run_loss (means), run_loss_standard_error, NaN for one
    run that chance has made;
    decision_loss_share and run_loss_share: these as shares of the mean cost of a run; agreement.
    """
    groups = trials.groupby(GROUP, sort=False)
    table = groups[["decision_loss", "run_loss", "agreement"]].mean()
    cost = -groups["discounted_return"].mean()
    table["trials"] = groups.size()
    error = groups["run_loss"].std(ddof=1) / groups.size() ** 0.5
    table["run_loss_standard_error"] = error.mask(groups["deterministic"].all(), 0.0)
    for name in ("decision_loss", "run_loss"):
        table[f"{name}_share"] = (table[name] / cost).where(cost > 0, 0.0)
    order = trials.drop_duplicates(GROUP[:2]).reset_index()[GROUP[:2]].reset_index(names="place")
    ranked = table.reset_index().merge(order, on=GROUP[:2]).sort_values(["place", "run_loss"], kind="stable")
    return ranked.drop(columns="place").reset_index(drop=True)


def regret_text(table: pd.DataFrame, references: dict[str, str]) -> str:
    """The table in words; `references`: how each condition's reference is called."""
    lines = [
        "Regret: what a policy's decisions lose against the reference's values in the states it visits, per run",
        "(mean ± standard error, and as a share of the run's cost), per decision, and how often nothing is lost.",
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

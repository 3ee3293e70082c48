"""How much the policies' decisions lose against the reference."""

from collections.abc import Sequence

import pandas as pd
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.style import house_style, look, new_figure, set_title

WIDE = 2  # standard errors that a bar reaches to either side


@house_style()
def regret_figure(regrets: pd.DataFrame, n_cycles: int, policies: Sequence[str]) -> Figure:
    """Loss per run as share of its cost, one panel per condition, for one number of cycles.

    `regrets` is the table of `statistics.regret`.
    """
    table = regrets[regrets["n_cycles"] == n_cycles]
    conditions = list(dict.fromkeys(table["condition"]))
    figure = new_figure(7.2, 0.8 + 0.2 * len(policies))
    axes = figure.subplots(1, len(conditions), squeeze=False, sharey=True, sharex=True)[0]
    for panel, condition in zip(axes, conditions, strict=True):
        cell = table[table["condition"] == condition].set_index("policy")
        for index, policy in enumerate(policies):
            if policy not in cell.index:
                continue
            row = cell.loc[policy]
            marker, colour = look(list(policies).index(policy))
            loss = 100 * row["run_loss_share"]
            spread = (
                100
                * row["run_loss_standard_error"]
                * (row["run_loss_share"] / row["run_loss"] if row["run_loss"] else 0)
            )
            panel.errorbar(
                loss,
                index,
                xerr=WIDE * spread if spread > 0 else None,
                fmt=marker,
                color=colour,
                capsize=2.5,
                markersize=4.5,
            )
            panel.annotate(
                f"{loss:.2g}" if loss else "0", (loss + WIDE * max(spread, 0), index), (5, 0),
                textcoords="offset points", va="center", fontsize=7,
            )  # fmt: skip
        set_title(panel, f"{format_label(condition)}, {n_cycles} cycles")
        panel.set_yticks(range(len(policies)), [format_label(policy) for policy in policies])
        panel.set_ylim(len(policies) - 0.5, -0.5)
        panel.margins(x=0.2)
    axes[0].set_xlim(left=0)
    figure.supxlabel(
        f"lost by the decisions of a run, % of its cost (bars: ±{WIDE:g} standard errors of the mean)", fontsize=9
    )
    return figure

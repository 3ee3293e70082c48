"""What Figure 5 shows, as estimates: how much more each policy costs than one of them, with intervals."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fatigue_planner.core.text import format_label
from fatigue_planner.output.figures.style import house_style, look, new_figure, set_title
from fatigue_planner.study.statistics.contrast import contrast_of, is_compared
from fatigue_planner.study.statistics.pairing import cells_of

WIDTH_IN = 7.2


def estimate_table(contrasts: pd.DataFrame, trials: pd.DataFrame, anchor: str) -> pd.DataFrame:
    """Cost of every policy minus the anchor's with the same random numbers, as a fraction of the anchor's.

    With its interval; positive: costs more than the anchor. Pairs that no family compares are left out.
    """
    rows = []
    for condition, n_cycles, cell in cells_of(trials):
        for policy in dict.fromkeys(cell["policy"]):
            if not is_compared(contrasts, condition, n_cycles, policy, anchor):
                continue
            found = contrast_of(contrasts, condition, n_cycles, policy, anchor)
            cost = -found.second_mean or np.nan
            rows.append(
                {
                    "condition": condition, "n_cycles": n_cycles, "policy": policy, "anchor": anchor,
                    "extra_cost_share": -found.difference / cost, "low_share": -found.t_high / cost,
                    "high_share": -found.t_low / cost, "note": found.note,
                }
            )  # fmt: skip
    return pd.DataFrame(rows)


@house_style()
def estimate_figure(table: pd.DataFrame, margin: float, policies: Sequence[str]) -> Figure:
    """Panels of intervals: one row per condition, one column per number of cycles; the margin is shaded."""
    conditions, lengths = list(dict.fromkeys(table["condition"])), list(dict.fromkeys(table["n_cycles"]))
    shown = [policy for policy in policies if policy in set(table["policy"])]
    figure = new_figure(WIDTH_IN, len(conditions) * (0.75 + 0.19 * len(shown)) + 0.4)
    axes = figure.subplots(len(conditions), len(lengths), squeeze=False, sharey=True)
    for row, condition in enumerate(conditions):
        for column, n_cycles in enumerate(lengths):
            cell = table[(table["condition"] == condition) & (table["n_cycles"] == n_cycles)].set_index("policy")
            _panel(axes[row, column], cell, margin, shown, list(policies))
            set_title(axes[row, column], f"{format_label(str(condition))}, {n_cycles} cycles")
    anchor = format_label(str(table["anchor"].iloc[0]))
    figure.supxlabel(f"cost above that of {anchor}, % of it (shaded: ±{100 * margin:g} %, equivalent)", fontsize=9)
    return figure


def _panel(axes: Axes, cell: pd.DataFrame, margin: float, shown: Sequence[str], policies: list[str]) -> None:
    axes.axvspan(-100 * margin, 100 * margin, color="0.9", zorder=0, linewidth=0)
    axes.axvline(0, color="0.4", linewidth=0.8)
    for index, policy in enumerate(shown):
        if policy not in cell.index:
            continue
        columns = ["extra_cost_share", "low_share", "high_share"]
        centre, low, high = (100 * number for number in cell.loc[policy, columns].to_numpy(dtype=float))
        marker, colour = look(policies.index(policy))
        error = None if np.isnan(low) else [[centre - low], [high - centre]]
        axes.errorbar(centre, index, xerr=error, fmt=marker, color=colour, capsize=2.5, markersize=4.5)
    axes.set_yticks(range(len(shown)), [format_label(policy) for policy in shown])
    axes.set_ylim(len(shown) - 0.5, -0.5)

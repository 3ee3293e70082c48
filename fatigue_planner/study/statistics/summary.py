"""The summary a benchmark prints: one block per condition and number of cycles."""

import math
from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from fatigue_planner.study.statistics.rows import cells_of


def summary_text(comparison: pd.DataFrame, significance_level: float) -> str:
    """The comparison table in words, best policy first, each tested against the next one."""
    lines = [
        "Discounted return (higher is better): mean ± standard deviation over the trials.",
        f"Each policy is tested against the next one: Student's t-test, unpaired, at {100 * significance_level:g} % "
        "(ns: not significant).",
    ]
    for condition, n_cycles, cell in cells_of(comparison):
        lines += ["", f"{condition}, {n_cycles} cycles"]
        for row in cell.to_dict("records"):
            lines.append(f"  {row['rank']}. {row['policy']:<16} {_estimate(row)}  {_test(row)}".rstrip())
    return "\n".join(lines) + "\n"


def _estimate(row: Mapping[Hashable, Any]) -> str:
    if row["trials"] == 1:
        return f"{row['mean']:.6f}  ({'one deterministic run' if row['deterministic'] else 'one run'})"
    return f"{row['mean']:.6f} ± {row['standard_deviation']:.6f}  (n = {row['trials']})"


def _test(row: Mapping[Hashable, Any]) -> str:
    if math.isnan(row["p_value"]):
        return row["verdict"] if row["trials"] > 1 else ""
    return f"{row['verdict']} (p = {row['p_value']:.2g})"

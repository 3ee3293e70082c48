"""Means, standard deviations and the paper's t-tests between neighbours (section IV-E), and their summary in text."""

import math
import warnings
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from fatigue_planner.study.statistics.pairing import cells_of

Vector = NDArray[np.float64]

# Stars of Figure 5; the paper does not say its thresholds beyond 5 %, these are the usual ones.
STARS = ((0.001, "***"), (0.01, "**"), (0.05, "*"))


@dataclass(frozen=True)
class Ranked:
    """A policy in a cell of Figure 5 and its comparison with the next one in mean.

    p_value is NaN where there is no test, and `verdict` says why; else `verdict` is its stars or ns.
    """

    policy: str
    mean: float
    standard_deviation: float
    trials: int
    deterministic: bool
    p_value: float
    verdict: str


def rank_policies(cell: pd.DataFrame, significance_level: float) -> list[Ranked]:
    """Policies of one condition and number of cycles, best mean return first.

    `cell` has the columns policy, deterministic and discounted_return. Neighbours are compared by Student's
    two-sample t-test, unpaired, as in the paper; a policy with a single run has no distribution to
    test, so a comparison with it states no p-value.
    """
    samples = {str(name): rows.to_numpy() for name, rows in cell.groupby("policy", sort=False)["discounted_return"]}
    same = cell.groupby("policy", sort=False)["deterministic"].all()
    order = sorted(samples, key=lambda name: -float(samples[name].mean()))
    ranked = []
    for index, name in enumerate(order):
        values = samples[name]
        following = samples[order[index + 1]] if index + 1 < len(order) else None
        p_value, verdict = _compare(values, following, significance_level)
        spread = float(values.std(ddof=1)) if len(values) > 1 else 0.0
        mean, deterministic = float(values.mean()), bool(same[name])
        ranked.append(Ranked(name, mean, spread, len(values), deterministic, p_value, verdict))
    return ranked


def _compare(values: Vector, following: Vector | None, significance_level: float) -> tuple[float, str]:
    if following is None:
        return math.nan, ""
    if len(values) < 2 or len(following) < 2:
        return math.nan, "no test: a single run"
    if np.ptp(values) == 0 and np.ptp(following) == 0:
        return math.nan, "no test: both constant"
    from scipy.stats import ttest_ind  # noqa: PLC0415 - takes half a second

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # one of the two may be constant
        p_value = float(ttest_ind(values, following).pvalue)
    if p_value >= significance_level:
        return p_value, "ns"
    return p_value, next((mark for limit, mark in STARS if p_value < limit), "*")


RANK_COLUMNS = ["condition", "n_cycles", "rank", *(field.name for field in fields(Ranked))]


def comparison_table(trials: pd.DataFrame, significance_level: float) -> pd.DataFrame:
    """All cells of a table of trials, one row per policy, in rank order within each cell."""
    rows = []
    for condition, n_cycles, cell in cells_of(trials):
        for rank, ranked in enumerate(rank_policies(cell, significance_level), start=1):
            rows.append({"condition": condition, "n_cycles": n_cycles, "rank": rank} | vars(ranked))
    return pd.DataFrame(rows)


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

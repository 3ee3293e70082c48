"""The paper's t-tests between neighbours, and what is said where there is none."""

import math

import numpy as np
import pandas as pd
import pytest

from fatigue_planner.study.statistics.comparison import comparison_table, rank_policies, summary_text


def cell(**samples: list[float]) -> pd.DataFrame:
    rows = [(name, value) for name, values in samples.items() for value in values]
    return pd.DataFrame(rows, columns=["policy", "discounted_return"]).assign(deterministic=False)


def test_student_t_by_hand() -> None:
    """a: mean 3, variance 2.5; b: mean 1.5, variance 1.25: t = 1.5 / sqrt(1.875 * 2 / 5) on 8 degrees of freedom."""
    a, b = [1.0, 2, 3, 4, 5], [0.0, 1, 1.5, 2, 3]
    t = 1.5 / math.sqrt((np.var(a, ddof=1) + np.var(b, ddof=1)) / 2 * (2 / 5))
    x = np.linspace(t, 400, 4_000_001)  # two tails of Student's density with 8 degrees of freedom
    density = math.gamma(4.5) / (math.sqrt(8 * math.pi) * math.gamma(4)) * (1 + x**2 / 8) ** -4.5
    expected = 2 * np.trapezoid(density, x)
    first, second = rank_policies(cell(b=b, a=a), 0.05)
    assert (first.policy, second.policy) == ("a", "b")
    assert first.p_value == pytest.approx(expected, abs=1e-8) and first.verdict == "ns"
    assert math.isnan(second.p_value) and second.verdict == ""
    assert first.standard_deviation == pytest.approx(math.sqrt(2.5))


@pytest.mark.parametrize(("shift", "verdict"), [(0.0, "ns"), (0.65, "*"), (0.85, "**"), (1.5, "***")])
def test_stars_follow_the_p_value(shift: float, verdict: str) -> None:
    values = np.linspace(-1.7, 1.7, 25)
    first = rank_policies(cell(a=list(values + shift + 1e-9), b=list(values)), 0.05)[0]
    assert first.verdict == verdict, first.p_value


def test_single_runs_and_constants_state_no_p_value() -> None:
    ranked = rank_policies(cell(once=[3.0], dice=[1.0, 2.0], flat=[0.5, 0.5], level=[0.1, 0.1]), 0.05)
    assert [r.policy for r in ranked] == ["once", "dice", "flat", "level"]
    assert ranked[0].verdict == "no test: a single run" and math.isnan(ranked[0].p_value)
    assert not math.isnan(ranked[1].p_value)
    assert ranked[2].verdict == "no test: both constant" and math.isnan(ranked[2].p_value)


def test_summary_says_what_was_run_once() -> None:
    trials = pd.concat(
        [
            cell(a=[-1.0, -1.1, -1.2], b=[-2.0, -2.2, -2.1]).assign(condition="novice", n_cycles=5),
            cell(a=[-1.0]).assign(condition="expert", n_cycles=5, deterministic=True),
            cell(b=[-3.0, -2.0]).assign(condition="expert", n_cycles=5),
            cell(a=[-1.0]).assign(condition="brief", n_cycles=5),
        ]
    )
    text = summary_text(comparison_table(trials, 0.05), 0.05)
    assert "novice, 5 cycles" in text and "1. a                -1.100000 ± 0.100000  (n = 3)  *** (p = " in text
    assert "1. a                -1.000000  (one deterministic run)" in text
    assert "1. a                -1.000000  (one run)" in text

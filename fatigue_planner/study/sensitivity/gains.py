"""What planning gains over a baseline at every point, and how often each of the paper's claims holds."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from fatigue_planner.study.claims.evaluation import Judgements, judge_claims
from fatigue_planner.study.claims.loader import Claims
from fatigue_planner.study.claims.schema import Answer
from fatigue_planner.study.statistics.contrasts import contrasts
from fatigue_planner.study.statistics.pairing import cells_of

Vector = NDArray[np.float64]

# No verdict depends on resampling, so the smallest allowed number is enough.
MIN_RESAMPLES = 99
# The verdicts on the claims, by claim, from the trials of one point.
VerdictsOf = Callable[[pd.DataFrame], Mapping[str, Judgements]]
REPRODUCED = Answer.HOLDS.verdict
ANALYSES = ("modern", "paper")
CONFIDENCE = 0.95
# Differences up to this fraction of the cost are rounding errors.
ROUNDING = 1e-12
COLUMNS = [
    "point", "condition", "n_cycles", "planner", "baseline", "trials", "baseline_cost", "gain", "standard_error",
    "gain_low", "gain_high",    "verdict",
]  # fmt: skip


def gain_table(trials: Mapping[str, pd.DataFrame], planners: Sequence[str], baselines: Sequence[str]) -> pd.DataFrame:
    """One row per point, condition, length, planner and baseline (COLUMNS).

    `trials`: by point, as from `benchmark.tables`. gain: by how much the planner's mean cost is below the baseline's,
    as a fraction of the baseline's mean cost (0 where nothing costs anything). standard_error, and gain_low, gain_high,
    its 95 % confidence interval by Student's t: of the paired differences, the baseline's mean taken as given. A policy
    that was run once, because all its runs are the same, counts for every trial. verdict: better or worse where the
    interval excludes 0, else undecided; intervals are individual, so 5 % of zero differences are called better or
    worse.
    """
    rows = []
    for point, table in trials.items():
        for condition, n_cycles, cell in cells_of(table):
            costs = {str(name): -own.to_numpy() for name, own in cell.groupby("policy")["discounted_return"]}
            same = cell.groupby("policy")["deterministic"].all()
            for planner in planners:
                for baseline in baselines:
                    certain = bool(same[planner] and same[baseline])
                    gain = paired_gain(costs[planner], costs[baseline], certain)
                    rows.append((point, condition, n_cycles, planner, baseline, *gain))
    return pd.DataFrame(rows, columns=COLUMNS)


def paired_gain(planner: Vector, baseline: Vector, certain: bool) -> tuple[int, float, float, float, float, float, str]:
    """Trials, the baseline's mean cost, gain, standard error, interval and verdict, from costs (trials,) or (1,).

    `certain`: every run is the same, so that one is enough.
    """
    saved = baseline - planner
    cost = float(baseline.mean())
    unit = cost if cost > 0 else 1.0
    gain = float(saved.mean()) / unit
    gain = 0.0 if abs(gain) < ROUNDING else gain
    if certain:
        error = width = 0.0
    elif saved.size < 2:
        error = width = np.nan
    else:
        from scipy.stats import t  # noqa: PLC0415 - takes half a second

        error = float(saved.std(ddof=1)) / saved.size**0.5 / unit
        width = float(t.ppf((1 + CONFIDENCE) / 2, saved.size - 1)) * error
    low, high = gain - width, gain + width
    verdict = "better" if low > 0 else "worse" if high < 0 else "undecided"
    return saved.size, cost, gain, error, low, high, verdict


def leader_table(trials: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """The policy with the lowest mean cost, one row per point, condition and length."""
    rows = []
    for point, table in trials.items():
        for condition, n_cycles, cell in cells_of(table):
            means = cell.groupby("policy", sort=False)["discounted_return"].mean()
            rows.append((point, condition, n_cycles, str(means.idxmax()), -float(means.max())))
    return pd.DataFrame(rows, columns=["point", "condition", "n_cycles", "policy", "mean_cost"])


def judge(claims: Claims) -> VerdictsOf:
    """How the claims are judged at a point: as in the base experiment, ignoring policies it does not have."""
    experiment = claims.experiment
    statistics = experiment.statistics.model_copy(update={"resamples": MIN_RESAMPLES})

    def verdicts_of(trials: pd.DataFrame) -> Mapping[str, Judgements]:
        own = trials[trials["policy"].isin(experiment.benchmark.policies)]
        return judge_claims(claims.claims, own, contrasts(own, statistics, experiment.benchmark.seed), statistics)

    return verdicts_of


def verdict_table(trials: Mapping[str, pd.DataFrame], verdicts_of: VerdictsOf) -> pd.DataFrame:
    """The verdicts everywhere: one row per point, claim and analysis (modern, or the paper's own)."""
    rows = [
        (point, claim, analysis, getattr(judgements, analysis).answer.verdict)
        for point, table in trials.items()
        for claim, judgements in verdicts_of(table).items()
        for analysis in ANALYSES
    ]
    return pd.DataFrame(rows, columns=["point", "claim", "analysis", "verdict"])


def claim_table(found: pd.DataFrame) -> pd.DataFrame:
    """How many points have which verdict, from `verdict_table`.

    One row per claim, analysis and verdict: points, and share: the fraction of all points.
    """
    counts = found.groupby(["claim", "analysis", "verdict"], sort=False).size().reset_index(name="points")
    counts["share"] = counts["points"] / counts.groupby(["claim", "analysis"])["points"].transform("sum")
    return counts


def reproduced_fraction(claims: pd.DataFrame) -> pd.Series:
    """By claim, the fraction of the points at which it is reproduced (modern analysis), the largest first."""
    own = claims[claims["analysis"] == ANALYSES[0]]
    held = own["share"].where(own["verdict"] == REPRODUCED, 0.0)
    return held.groupby(own["claim"], sort=False).sum().sort_values(ascending=False, kind="stable")

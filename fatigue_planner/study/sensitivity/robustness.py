"""How often each of the paper's claims holds, over all points that can be performed."""

from collections.abc import Callable, Mapping

import pandas as pd

from fatigue_planner.study.claims.evaluation import Judgements, judge_claims
from fatigue_planner.study.claims.loader import Claims
from fatigue_planner.study.claims.schema import Answer
from fatigue_planner.study.statistics.contrasts import contrasts

# No verdict depends on resampling, so the smallest allowed number is enough.
MIN_RESAMPLES = 99

# The verdicts on the claims, by claim, from the trials of one point.
VerdictsOf = Callable[[pd.DataFrame], Mapping[str, Judgements]]

REPRODUCED = Answer.HOLDS.verdict
ANALYSES = ("modern", "paper")


def judge(claims: Claims) -> VerdictsOf:
    """How the claims are judged at a point: as in the base experiment, ignoring policies it does not have."""
    experiment = claims.experiment
    statistics = experiment.statistics.model_copy(update={"resamples": MIN_RESAMPLES})

    def verdicts_of(trials: pd.DataFrame) -> Mapping[str, Judgements]:
        own = trials[trials["policy"].isin(experiment.benchmark.policies)]
        return judge_claims(claims.claims, own, contrasts(own, statistics, experiment.benchmark.seed), statistics)

    return verdicts_of


def claim_table(trials: Mapping[str, pd.DataFrame], verdicts_of: VerdictsOf) -> pd.DataFrame:
    """How many points have which verdict.

    One row per claim, analysis (modern, or the paper's own) and verdict: points, and share: the fraction of all points.
    """
    rows = [
        (claim, analysis, getattr(judgements, analysis).answer.verdict)
        for table in trials.values()
        for claim, judgements in verdicts_of(table).items()
        for analysis in ANALYSES
    ]
    found = pd.DataFrame(rows, columns=["claim", "analysis", "verdict"])
    counts = found.groupby(["claim", "analysis", "verdict"], sort=False).size().reset_index(name="points")
    counts["share"] = counts["points"] / counts.groupby(["claim", "analysis"])["points"].transform("sum")
    return counts


def reproduced_fraction(claims: pd.DataFrame) -> pd.Series:
    """By claim, the fraction of the points at which it is reproduced (modern analysis), the largest first."""
    own = claims[claims["analysis"] == ANALYSES[0]]
    held = own["share"].where(own["verdict"] == REPRODUCED, 0.0)
    return held.groupby(own["claim"], sort=False).sum().sort_values(ascending=False, kind="stable")

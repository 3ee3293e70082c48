"""Which of the paper's claims hold how often, over all points that can be performed."""

from collections.abc import Callable, Mapping

import pandas as pd

# The verdicts on the claims, by claim, from the trials of one point.
VerdictsOf = Callable[[pd.DataFrame], Mapping[str, str]]

REPRODUCED = "reproduced"


def claim_table(trials: Mapping[str, pd.DataFrame], verdicts_of: VerdictsOf) -> pd.DataFrame:
    """One row per claim and verdict: claim, verdict, points (how many have it) and share (of all with the claim)."""
    rows = [
        (claim, verdict)
        for table in trials.values()
        for claim, verdict in verdicts_of(table).items()
    ]  # fmt: skip
    verdicts = pd.DataFrame(rows, columns=["claim", "verdict"])
    counts = verdicts.groupby(["claim", "verdict"], sort=False).size().reset_index(name="points")
    counts["share"] = counts["points"] / counts.groupby("claim")["points"].transform("sum")
    return counts


def reproduced_share(claims: pd.DataFrame) -> pd.Series:
    """By claim, in which share of the points it is reproduced, the most robust claim first."""
    held = claims["share"].where(claims["verdict"] == REPRODUCED, 0.0)
    return held.groupby(claims["claim"], sort=False).sum().sort_values(ascending=False, kind="stable")
